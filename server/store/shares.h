// Who comes first and who may keep how much: the same in every JobStore.
#pragma once

#include <cstdint>
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

}  // namespace meshgauge::server::store
