#include "server/worker/pending_results.h"

#include <algorithm>
#include <new>

#include "bench_of_workers.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::seconds;
using store::got;
using store::JobState;
using How = PendingResults::Outcome;

namespace {

struct Delivered : PendingResults::Listener {
  std::mutex mutex;
  std::vector<std::pair<std::string, How>> all;
  std::atomic<int> failures{0};

  void delivered(const PendingResult& delivery, How outcome) override {
    const std::lock_guard lock(mutex);
    all.emplace_back(delivery.job->live->key.id, outcome);
  }
  void failed(const Error&) override { ++failures; }
};

// Has no memory for the fourth call.
struct ShortOfMemory final : Delivered {
  int left = 3;

  void delivered(const PendingResult& delivery, How outcome) override {
    if (left-- == 0) throw std::bad_alloc();
    Delivered::delivered(delivery, outcome);
  }
};

HeldJobPtr claimed(Kept& kept, const std::string& name) {
  const auto key = put_job(kept, job_named(name));
  const auto now = store::now();
  const auto one = store::claim_one(kept.embedded.jobs(), key, "w", now, now + seconds(60));
  REQUIRE(one.has_value());
  auto job = std::make_shared<HeldJob>();
  job->live = live_job_of(one->job, one_worker(), {});
  job->token = one->token;
  return job;
}

PendingResult done(const HeldJobPtr& job, const std::string& document = "{}") {
  const auto now = store::now();
  return {job, store::Ending{JobState::done, document, "", now, now + seconds(60)}, std::nullopt, ""};
}

constexpr auto kEnough = std::chrono::seconds(60);

}  // namespace

TEST_CASE("pending results: those that come while the store is busy or away are stored in one group") {
  Kept kept;
  Delivered delivered;
  std::vector<HeldJobPtr> jobs;
  for (int i = 0; i < 20; ++i) jobs.push_back(claimed(kept, "j" + std::to_string(i)));
  PendingResults results(kept.jobs, {}, delivered);
  kept.jobs.full = true;
  for (const auto& job : jobs) results.add(done(job));
  REQUIRE(eventually([&] { return delivered.failures > 0; }));
  CHECK(results.waiting() == 20);
  kept.jobs.full = false;
  const int before = kept.jobs.finishes;
  results.hurry();
  REQUIRE(results.wait_until_empty(PendingResults::Clock::now() + kEnough));
  CHECK(kept.jobs.finishes - before <= 2);  // one may have been on its way with the first alone
  CHECK(delivered.all.size() == 20);
  for (const auto& job : jobs) CHECK(has_state(kept, job->live->key, JobState::done));
}

TEST_CASE("pending results: one with an old token is refused, the others are stored") {
  Kept kept;
  Delivered delivered;
  const auto mine = claimed(kept, "mine");
  const auto lost = claimed(kept, "lost");
  got(kept.embedded.jobs().hand_back(lost->token, "", {store::now(), store::now() + seconds(60)}));
  PendingResults results(kept.jobs, {}, delivered);
  results.add(done(lost));
  results.add(done(mine));
  REQUIRE(results.wait_until_empty(PendingResults::Clock::now() + kEnough));
  CHECK(delivered.all == std::vector<std::pair<std::string, How>>{{"lost", How::refused}, {"mine", How::stored}});
  CHECK(has_state(kept, lost->live->key, JobState::queued));
}

TEST_CASE("pending results: a hand-back stores its interval") {
  Kept kept;
  Delivered delivered;
  const auto job = claimed(kept, "back");
  PendingResults results(kept.jobs, {}, delivered);
  results.add({job, std::nullopt, store::Progress{1, 2, "traverse"}, ""});
  REQUIRE(results.wait_until_empty(PendingResults::Clock::now() + kEnough));
  const auto row = row_of(kept, job->live->key);
  CHECK(row.state == JobState::queued);
  CHECK(row.progress == store::Progress{1, 2, "traverse"});
}

TEST_CASE("pending results: an end that the store can never take counts against its job, and blocks no other") {
  Kept kept;
  Delivered delivered;
  const auto poison = claimed(kept, "poison");
  const auto other = claimed(kept, "other");
  kept.jobs.refused_document = "poison";
  PendingResults results(kept.jobs, {}, delivered);
  results.add(done(poison, "poison"));
  results.add(done(other));
  REQUIRE(results.wait_until_empty(PendingResults::Clock::now() + kEnough));
  CHECK(has_state(kept, other->live->key, JobState::done));
  const auto row = row_of(kept, poison->live->key);
  CHECK(row.state == JobState::queued);
  CHECK(row.last_error.find("its end could not be stored") != std::string::npos);
}

TEST_CASE("pending results: what the store takes neither as an end nor back is kept, and blocks no other") {
  Kept kept;
  Delivered delivered;
  const auto damaged = claimed(kept, "damaged");
  const auto back = claimed(kept, "back");
  kept.jobs.set_damaged({"damaged", "back"});
  PendingResults results(kept.jobs, {}, delivered);
  results.add(done(damaged));
  results.add({back, std::nullopt, std::nullopt, ""});
  REQUIRE(eventually([&] { return kept.jobs.refused >= 6; }));  // each more than once
  const auto other = claimed(kept, "other");
  results.add(done(other));
  REQUIRE(eventually([&] { return has_state(kept, other->live->key, JobState::done); }));
  CHECK(results.waiting() >= 2);
  kept.jobs.set_damaged({});
  results.hurry();
  REQUIRE(results.wait_until_empty(PendingResults::Clock::now() + kEnough));
  CHECK(has_state(kept, damaged->live->key, JobState::done));
  CHECK(has_state(kept, back->live->key, JobState::queued));
}

TEST_CASE("pending results: out of memory, those that are not settled are tried again, the others are not") {
  Kept kept;
  ShortOfMemory delivered;
  std::vector<HeldJobPtr> jobs;
  for (int i = 0; i < 5; ++i) jobs.push_back(claimed(kept, "j" + std::to_string(i)));
  PendingResults results(kept.jobs, {}, delivered);
  kept.jobs.full = true;  // so that they become one group
  for (const auto& job : jobs) results.add(done(job));
  REQUIRE(eventually([&] { return delivered.failures > 0; }));
  kept.jobs.full = false;
  results.hurry();
  REQUIRE(results.wait_until_empty(PendingResults::Clock::now() + kEnough));
  std::vector<std::pair<std::string, How>> each_once;
  for (const auto& job : jobs) each_once.emplace_back(job->live->key.id, How::stored);
  std::sort(delivered.all.begin(), delivered.all.end());  // the first may have been tried alone, before the others came
  CHECK(delivered.all == each_once);
  CHECK(results.waiting() == 0);
}
