// What becomes of the other parts of a comparison when the store gives up one of them.
#include "job_steps.h"
#include "server/store/part_store.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

// "w" of three parts, of which w.0 is to fail and w.1 runs at a worker that lives.
struct Whole {
  explicit Whole(TimePoint first_expires = at(3600)) {
    std::vector<NewJob> parts;
    for (int i = 0; i < 3; ++i) parts.push_back(new_job("ann", "w." + std::to_string(i)));
    parts.front().expires_if_never_run = first_expires;
    REQUIRE_FALSE(got(stores.parts().insert_parts(new_job("ann", "w"), parts)).existed);
  }
  JobStore& jobs() { return stores.jobs(); }
  JobState state_of(const std::string& id) { return job_in(jobs(), {"ann", id}).state; }
  Token run(const std::string& id, const std::string& worker) { return claimed_token(jobs(), {"ann", id}, worker); }
  // As often as it is tried, but for the last time.
  void lose_first() {
    for (unsigned i = 1; i < kMaxTries; ++i) {
      CHECK(got(jobs().hand_back(run("w.0", "lost"), "its worker died", kNow)) == JobState::queued);
    }
  }
  void check_stopped(const Token& running) {
    CHECK(state_of("w.0") == JobState::failed);
    CHECK(state_of("w.2") == JobState::cancelled);
    CHECK(state_of("w") == JobState::queued);
    CHECK(got(jobs().heartbeat(running, at(500), {1, 2, "reduce"})) == Heartbeat::cancel);
    CHECK_FALSE(got(jobs().claim({"ann", "w"}, "w", at(50), at(110))).has_value());
    CHECK(got(jobs().finish(running, ending(JobState::cancelled))));
    CHECK(got(jobs().claim({"ann", "w"}, "w", at(50), at(110))).has_value());
  }

  PostgresForTests stores;
};

}  // namespace

TEST_CASE("given up parts: one that is handed back too often stops the others") {
  Whole whole;
  whole.lose_first();
  CHECK(whole.state_of("w.2") == JobState::queued);
  const Token running = whole.run("w.1", "living");
  CHECK(got(whole.jobs().hand_back(whole.run("w.0", "lost"), "its worker died", kNow)) == JobState::failed);
  whole.check_stopped(running);
}

TEST_CASE("given up parts: one whose workers die too often stops the others") {
  Whole whole;
  whole.lose_first();
  const Token running = whole.run("w.1", "living");
  whole.run("w.0", "lost");
  got(whole.jobs().recover("lost", "its worker died", kNow));
  whole.check_stopped(running);
}

TEST_CASE("given up parts: others that are lost with it are not tried again") {
  Whole whole;
  whole.lose_first();
  for (const std::string id : {"w.0", "w.1"}) whole.run(id, "lost");
  const Token running = whole.run("w.2", "living");
  got(whole.jobs().recover("lost", "its worker died", kNow));
  CHECK(whole.state_of("w.0") == JobState::failed);
  CHECK(whole.state_of("w.1") == JobState::cancelled);
  CHECK(got(whole.jobs().finish(running, ending(JobState::cancelled))));
  whole.run("w", "w");
}

TEST_CASE("given up parts: one that nobody ran in time stops the others") {
  Whole whole(at(200));
  const Token running = whole.run("w.1", "living");
  CHECK(got(whole.jobs().sweep_jobs({at(300), at(1300)}, 100)).given_up == 0);
  whole.check_stopped(running);
}

TEST_CASE("given up parts: the others of another whole go on") {
  Whole whole;
  std::vector<NewJob> parts{new_job("ann", "v.0")};
  REQUIRE_FALSE(got(whole.stores.parts().insert_parts(new_job("ann", "v"), parts)).existed);
  insert(whole.jobs(), new_job("ann", "alone"));
  whole.lose_first();
  got(whole.jobs().hand_back(whole.run("w.0", "lost"), "its worker died", kNow));
  for (const std::string id : {"v.0", "v", "alone"}) CHECK(whole.state_of(id) == JobState::queued);
}
