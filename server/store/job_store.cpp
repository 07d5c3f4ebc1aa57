#include "server/store/job_store.h"

#include <algorithm>
#include <utility>

namespace meshgauge::server::store {

std::string to_string(JobState state) {
  switch (state) {
    case JobState::queued:
      return "queued";
    case JobState::running:
      return "running";
    case JobState::done:
      return "done";
    case JobState::failed:
      return "failed";
    case JobState::cancelled:
      return "cancelled";
  }
  return "";
}

Progress narrowed(const std::optional<Progress>& known, const Progress& newer) {
  if (!known || known->by.empty() || known->by != newer.by) return newer;
  const double lower = std::max(known->lower, newer.lower);
  const double upper = std::min(known->upper, newer.upper);
  if (lower > upper) return newer;
  return {lower, upper, newer.stage, newer.by};
}

Result<std::vector<Job>> JobStore::get_many(std::span<const JobKey> keys) {
  std::vector<Job> jobs;
  for (const JobKey& key : keys) {
    auto job = get(key);
    if (!job) return job.error();
    if (*job) jobs.push_back(std::move(**job));
  }
  return jobs;
}

}  // namespace meshgauge::server::store
