// Decisions that are the same in every JobStore: pure functions over what a store reads.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

// The order of claim_some(), lowest first: earlier by one second is as good as smaller by kBytesOfOneSecond.
std::int64_t rank_of(const NewJob& job);

// A running job whose try ends without a result.
struct Loss {
  unsigned tries = 0;  // with this one
  unsigned excused = 0;
  bool cancel_requested = false;
  bool in_batch = false;
  bool told_progress = false;  // in this try
};

struct AfterLoss {
  JobState state = JobState::queued;
  unsigned excused = 0;
};

// What becomes of it. An excused try does not count towards kMaxTries.
AfterLoss after_hand_back(const Loss& loss, bool excused);
// The same when it was lost with its worker. A job of a batch that has told no progress is excused, unless it is
// suspected or was excused kMaxUnbegun times: most likely it was one of many that were claimed at once, and another one
// ran.
AfterLoss after_loss(const Loss& loss);

struct Kept {
  std::string owner;
  std::uint64_t jobs = 0;
};

// What each owner may keep of `max_kept` for all: an equal share, and of what others leave of theirs as much as is
// needed. Whoever keeps little loses nothing to one who keeps much.
std::uint64_t share_of(std::vector<Kept> kept, std::uint64_t max_kept);

// Removes what owners keep beyond their share, at most `most`, by `remove_oldest` of an owner and a number, which says
// how many it has removed. How many there were.
std::uint64_t remove_over_share(
    const std::vector<Kept>& kept, std::uint64_t max_kept, std::uint64_t most,
    const std::function<std::uint64_t(const std::string& owner, std::uint64_t wanted)>& remove_oldest);

}  // namespace meshgauge::server::store
