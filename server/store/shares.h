// Who comes first and who may keep how much: the same in every JobStore.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

// The order of claim_some(), lowest first: earlier by one second is as good as smaller by kBytesOfOneSecond.
std::int64_t rank_of(const NewJob& job);

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
