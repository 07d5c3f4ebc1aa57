// The progress of a job, as its workers report it one after the other.
#include <limits>

#include "job_steps.h"

namespace meshgauge::server::store {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::optional<Progress> progress_of(JobStore& jobs) { return job_in(jobs, {"ann", "1"}).progress; }

void tell(JobStore& jobs, const Token& token, const Progress& progress) {
  CHECK(got(heartbeat(jobs, token, at(170), progress)) == Heartbeat::go_on);
}

}  // namespace

TEST_CASE("progress: the better of each bound, if one engine certified both") {
  const Progress known{1, 9, "traverse", "v1"};
  CHECK(narrowed(std::nullopt, known) == known);
  CHECK(narrowed(known, {0, 8, "reduce", "v1"}) == Progress{1, 8, "reduce", "v1"});
  CHECK(narrowed(known, {2, kInfinity, "build", "v1"}) == Progress{2, 9, "build", "v1"});
  CHECK(narrowed(known, {0, 10, "", "v1"}) == Progress{1, 9, "", "v1"});
  CHECK(narrowed(known, {0, 10, "build", "v2"}) == Progress{0, 10, "build", "v2"});
  CHECK(narrowed(Progress{1, 9, "traverse", ""}, {0, 10, "build", ""}) ==
        Progress{0, 10, "build", ""});  // unknown engines
}

TEST_CASE("progress: contradicting intervals are not mixed") {
  CHECK(narrowed(Progress{1, 2, "reduce", "v1"}, {3, 4, "build", "v1"}) == Progress{3, 4, "build", "v1"});
  CHECK(narrowed(Progress{3, 4, "reduce", "v1"}, {1, 2, "build", "v1"}) == Progress{1, 2, "build", "v1"});
  CHECK(narrowed(Progress{1, 2, "reduce", "v1"}, {2, 4, "build", "v1"}) == Progress{2, 2, "build", "v1"});
}

TEST_CASE_TEMPLATE("progress: the interval of a job only shrinks, also in a new try", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(jobs, new_job("ann", "1"));
  const Token first = claimed_token(jobs, {"ann", "1"});
  CHECK_FALSE(progress_of(jobs).has_value());
  tell(jobs, first, {0, kInfinity, "build", "v1"});
  tell(jobs, first, {1.5, 9, "traverse", "v1"});
  tell(jobs, first, {1.25, 8, "traverse", "v1"});
  CHECK(progress_of(jobs) == Progress{1.5, 8, "traverse", "v1"});
  CHECK(got(jobs.hand_back(first, "", kNow)) == JobState::queued);
  CHECK(progress_of(jobs) == Progress{1.5, 8, "traverse", "v1"});

  const std::optional<Claimed> second = claim_one(jobs, {"ann", "1"}, "w2", at(50), at(110));
  REQUIRE(second.has_value());
  CHECK(second->job.progress == Progress{1.5, 8, "", "v1"});  // this try has no stage yet
  tell(jobs, second->token, {0, kInfinity, "build", "v1"});
  CHECK(progress_of(jobs) == Progress{1.5, 8, "build", "v1"});
  const Beat alive{second->token, std::nullopt};
  got(jobs.heartbeats({&alive, 1}, at(170)));
  CHECK(progress_of(jobs) == Progress{1.5, 8, "build", "v1"});
  tell(jobs, second->token, {2, 8.5, "reduce", "v1"});
  CHECK(progress_of(jobs) == Progress{2, 8, "reduce", "v1"});

  got(jobs.recover("w2", "its worker was lost", kNow));
  const auto third = got(jobs.claim_some("w3", at(50), at(110), 1));
  REQUIRE(third.size() == 1);
  CHECK(third[0].job.progress == Progress{2, 8, "", "v1"});
  CHECK(got(heartbeat(jobs, second->token, at(170), {4, 5, "reduce", "v1"})) == Heartbeat::lost);
  CHECK(progress_of(jobs) == Progress{2, 8, "", "v1"});
}

TEST_CASE_TEMPLATE("progress: bounds of another engine, or contradicting ones, replace the known ones", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(jobs, new_job("ann", "1"));
  const Token token = claimed_token(jobs, {"ann", "1"});
  tell(jobs, token, {2, 8, "reduce", "v1"});
  SUBCASE("another engine") {
    CHECK(got(jobs.hand_back(token, "", kNow)) == JobState::queued);
    const Token by_another = claimed_token(jobs, {"ann", "1"}, "w2");
    tell(jobs, by_another, {0, kInfinity, "build", "v2"});
    CHECK(progress_of(jobs) == Progress{0, kInfinity, "build", "v2"});
    tell(jobs, by_another, {1, 9, "traverse", "v2"});
    CHECK(progress_of(jobs) == Progress{1, 9, "traverse", "v2"});
  }
  SUBCASE("a contradiction") {
    tell(jobs, token, {9, 10, "reduce", "v1"});
    CHECK(progress_of(jobs) == Progress{9, 10, "reduce", "v1"});
  }
}

TEST_CASE_TEMPLATE("progress: many jobs at once, each with its own", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  std::vector<Beat> beats;
  for (int i = 0; i < 4; ++i) {
    const std::string id = std::to_string(i);
    insert(jobs, new_job("ann", id));
    const Token token = claimed_token(jobs, {"ann", id});
    tell(jobs, token, {1.0 + i, 10, "traverse", "v1"});
    if (i != 2) beats.push_back({token, Progress{2.5, 9.0 + i, "reduce", "v1"}});
    if (i == 2) beats.push_back({token, std::nullopt});
  }
  CHECK(got(jobs.heartbeats(beats, at(180))) == std::vector<Heartbeat>(4, Heartbeat::go_on));
  CHECK(job_in(jobs, {"ann", "0"}).progress == Progress{2.5, 9, "reduce", "v1"});
  CHECK(job_in(jobs, {"ann", "1"}).progress == Progress{2.5, 10, "reduce", "v1"});
  CHECK(job_in(jobs, {"ann", "2"}).progress == Progress{3, 10, "traverse", "v1"});
  CHECK(job_in(jobs, {"ann", "3"}).progress == Progress{4, 10, "reduce", "v1"});
}

}  // namespace meshgauge::server::store
