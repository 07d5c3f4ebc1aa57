// The implementations that every test of the interfaces runs over: TEST_CASE_TEMPLATE("...", Stores,
// EVERY_IMPLEMENTATION).
//
// Each is a class whose objects begin empty, with jobs(), batches(), meshes(), blobs() and reopen(), an orderly restart
// of the service.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "server/store/forms/stores.h"
#include "store_text.h"
#include "test_folder.h"

#ifdef MESHGAUGE_TESTS_OF_POSTGRES  // postgres_tests has a server to start: its suites run in one process
#define EVERY_IMPLEMENTATION PostgresForTests
#define EVERY_BLOB_STORE EVERY_IMPLEMENTATION
#else
#define EVERY_IMPLEMENTATION EmbeddedForTests
// For tests of blobs: blobs() and reopen() are enough. s3/s3_for_tests.h
#define EVERY_BLOB_STORE EVERY_IMPLEMENTATION, S3ForTests
#endif

namespace meshgauge::server::store {

class EmbeddedForTests {
 public:
  static constexpr bool kListsRecovered = true;  // JobStore::recover()

  EmbeddedForTests() { reopen(); }

  JobStore& jobs() { return stores_->jobs(); }
  MeshIndex& meshes() { return stores_->meshes(); }
  BatchStore& batches() { return stores_->batches(); }
  Listings& listings() { return stores_->listings(); }
  BlobStore& blobs() { return stores_->blobs(); }
  Signals& signals() { return stores_->signals(); }
  void reopen() {
    stores_.reset();
    stores_ = got(AllStores::open_embedded({folder_ / "data", 50}));
  }
  const TestFolder& folder() const { return folder_; }

 private:
  TestFolder folder_;
  std::unique_ptr<AllStores> stores_;
};

inline TimePoint at(std::int64_t seconds) { return TimePoint(std::chrono::seconds(1'700'000'000 + seconds)); }

inline NewJob new_job(const std::string& owner, const std::string& id) {
  NewJob job;
  job.key = {owner, id};
  job.mesh_a = std::string(64, 'a');
  job.mesh_b = std::string(64, 'b');
  job.hints = R"({"a":"α.stl"})";
  job.options = R"({"tolerance":{"absolute":0.1}})";
  job.cost = 1000;
  job.fingerprint = "print of " + id;
  job.trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  job.created = at(0);
  job.expires_if_never_run = at(3600);
  return job;
}

inline Job ended_job(const std::string& owner, const std::string& id, TimePoint finished = at(10)) {
  Job job;
  static_cast<NewJob&>(job) = new_job(owner, id);
  job.state = JobState::done;
  job.tries = 1;
  job.started = at(5);
  job.finished = finished;
  job.expires = at(1000);
  job.document = R"({"status":"converged"})";
  return job;
}

// Claims this job, and hands other queued jobs back. nullopt: it cannot be claimed.
inline std::optional<Claimed> claim_one(JobStore& jobs, const JobKey& key, const std::string& worker, TimePoint now,
                                        TimePoint lease_until) {
  std::optional<Claimed> found;
  std::vector<Token> others;
  for (auto some = got(jobs.claim_some(worker, now, lease_until, 1)); !some.empty();
       some = got(jobs.claim_some(worker, now, lease_until, 1))) {
    if (some.front().token.key == key) {
      found = std::move(some.front());
      break;
    }
    others.push_back(some.front().token);
  }
  for (const Token& token : others) got(jobs.hand_back(token, "", {now, now}));
  return found;
}

}  // namespace meshgauge::server::store

TYPE_TO_STRING_AS("embedded", meshgauge::server::store::EmbeddedForTests);

#ifdef MESHGAUGE_TESTS_OF_POSTGRES
#include "postgres_for_tests.h"
#endif
