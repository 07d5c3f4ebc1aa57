// How much of something common one client may take.
//
// Share: a client may take more as long as it has less than three times what is free. So one client alone has a share
// of three quarters, two have three sevenths each, and some is always free for one that has nothing. (After Choudhury
// and Hahne, "Dynamic Queue Length Thresholds for Shared-Memory Packet Switches", IEEE/ACM Transactions on Networking
// 1998.)
//
// Bytes of uploads end there: their limit is what the disk or the memory has. Of places in a queue, a client at its
// share also gets those that are free, until all places of the limit are taken. Such a place is beyond its share and
// takes nothing from the shares of others: it does not count as taken where they ask for a place within theirs, and it
// comes within its client's share only when the client gives a place back and its share allows it. For others it is
// like a request that was refused and is sent again. So a client alone gets all places, and clients that come then find
// as many as its share leaves free.
//
// A client at its share has three times what is free, so at most a quarter of the limit is free then, and at most that
// many places are beyond the shares of all clients.
#pragma once

#include <cstdint>

namespace meshgauge::server {

inline constexpr std::uint64_t kTimesTheFree = 3;

// Whether a client that has `own` may take more of what is free.
inline bool within_share(std::uint64_t own, std::uint64_t free) { return own / kTimesTheFree < free; }

// Places that are taken, of one client or of all.
struct TakenPlaces {
  std::uint64_t within = 0;  // within the shares of clients; of all at most the limit
  std::uint64_t beyond = 0;

  std::uint64_t all() const { return within + beyond; }
};

enum class NextPlace { none, within_share, beyond_share };

// The place that a client with `own` places gets next, of `limit` places of which `all` are taken.
inline NextPlace next_place(const TakenPlaces& own, const TakenPlaces& all, std::uint64_t limit) {
  if (within_share(own.within, limit - all.within)) return NextPlace::within_share;
  return all.all() < limit ? NextPlace::beyond_share : NextPlace::none;
}

}  // namespace meshgauge::server
