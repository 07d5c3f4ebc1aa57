// The decisions that both stores share, without a store.
#include "server/store/policy.h"

#include "server/store/transitions.h"

#include <doctest/doctest.h>

using namespace meshgauge::server::store;

TEST_CASE("policy: an excused try does not count") {
  const Loss fifth{kMaxTries, 0};
  CHECK(after_hand_back(fifth, true).state == JobState::queued);
  CHECK(after_hand_back(fifth, true).excused == 1);
  CHECK(after_hand_back(fifth, false).state == JobState::failed);
  CHECK(after_hand_back({kMaxTries, 1}, false).state == JobState::queued);
  CHECK(after_hand_back({kMaxTries - 1, 0}, false).state == JobState::queued);
}

TEST_CASE("policy: a job with a requested cancel is cancelled, in any try") {
  for (const unsigned tries : {1U, kMaxTries, kMaxTries + 3}) {
    CHECK(after_hand_back({tries, 0, true}, false).state == JobState::cancelled);
    CHECK(after_loss({tries, 0, true}).state == JobState::cancelled);
  }
}

TEST_CASE("policy: with its worker lost, a job of a batch without progress is excused, twice at most") {
  const auto excused = [](const Loss& loss) { return after_loss(loss).excused - loss.excused; };
  CHECK(excused({1, 0, false, true, false}) == 1);
  CHECK(excused({1, 0, false, true, true}) == 0);
  CHECK(excused({1, 0, false, false, false}) == 0);
  CHECK(excused({2, 0, false, true, false}) == 0);  // suspected
  CHECK(excused({2, 1, false, true, false}) == 1);
  CHECK(excused({kMaxUnbegun + 1, kMaxUnbegun, false, true, false}) == 0);
}

TEST_CASE("policy: the next group has the fewest running jobs, then the lowest rank") {
  CHECK(next_group({}) == nullptr);
  const std::vector<Group> groups{{"a", 5, 1}, {"b", 9, 0}, {"c", 7, 0}, {"d", 1, 2}};
  CHECK(next_group(groups)->name == "c");
  CHECK(next_group(groups, JobStore::Clients::with_none_running)->name == "c");
  const std::vector<Group> busy{{"a", 5, 1}, {"d", 1, 2}};
  CHECK(next_group(busy)->name == "a");
  CHECK(next_group(busy, JobStore::Clients::with_none_running) == nullptr);
}

TEST_CASE("policy: a claim takes what fits into one second, at least one job, and none beside a suspected one") {
  constexpr std::uint64_t kFull = JobStore::kBytesOfOneSecond;
  using Candidates = std::vector<Candidate>;
  CHECK(fit_in_claim({}) == 0);
  CHECK(fit_in_claim(Candidates{{2 * kFull, false}, {1, false}}) == 1);
  CHECK(fit_in_claim(Candidates{{kFull - 1, false}, {1, false}, {1, false}}) == 2);
  CHECK(fit_in_claim(Candidates{{1, false}, {1, false}, {1, true}, {1, false}}) == 2);
  CHECK(fit_in_claim(Candidates{{1, true}, {1, false}}) == 1);
}

TEST_CASE("policy: each owner keeps an equal share, and what others leave") {
  CHECK(share_of({}, 10) == 10);
  CHECK(share_of({{"ann", 4}, {"bob", 6}}, 10) == 10);
  CHECK(share_of({{"ann", 2}, {"bob", 100}}, 10) == 8);
  CHECK(share_of({{"ann", 50}, {"bob", 100}}, 10) == 5);
}

TEST_CASE("policy: what goes is beyond the shares, and no more than one portion") {
  const auto beyond = [](std::uint64_t max_kept, std::uint64_t most) {
    std::string text;
    for (const auto& [owner, jobs] : beyond_share({{"ann", 50}, {"bob", 2}, {"cat", 40}}, max_kept, most)) {
      text += owner + std::to_string(jobs) + " ";
    }
    return text;
  };
  CHECK(beyond(92, 500) == "");
  CHECK(beyond(82, 500) == "ann10 ");
  CHECK(beyond(62, 500) == "ann20 cat10 ");
  CHECK(beyond(62, 25) == "ann20 cat5 ");
  CHECK(beyond(62, 20) == "ann20 ");
  CHECK(beyond(0, 1) == "ann1 ");
}
