// Steps of a job that must succeed, for tests of what follows.
#pragma once

#include <optional>
#include <string>

#include "implementations.h"
#include "single_job.h"

namespace meshgauge::server::store {

inline const Moment kNow{at(100), at(1100)};

inline Job job_in(JobStore& jobs, const JobKey& key) {
  const std::optional<Job> job = got(jobs.get(key));
  REQUIRE(job.has_value());
  return *job;
}

inline Token claimed_token(JobStore& jobs, const JobKey& key, const std::string& worker = "w1") {
  const std::optional<Claimed> claimed = claim_one(jobs, key, worker, at(50), at(110));
  REQUIRE(claimed.has_value());
  return claimed->token;
}

inline void insert(JobStore& jobs, const NewJob& job) { REQUIRE(!got(jobs.insert(job)).existed); }

inline Ending ending(JobState state = JobState::done) { return {state, "{\"d\":1}", "", at(120), at(1120)}; }

}  // namespace meshgauge::server::store
