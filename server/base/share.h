// How much of something common one client may take.
//
// A client may take more as long as it has less than three times what is free. So one client alone gets three quarters,
// two get three sevenths each, and some is always free for one that has nothing. (After Choudhury and Hahne, "Dynamic
// Queue Length Thresholds for Shared-Memory Packet Switches", IEEE/ACM Transactions on Networking 1998.)
#pragma once

#include <cstdint>

namespace meshgauge::server {

inline constexpr std::uint64_t kTimesTheFree = 3;

// Whether a client that has `own` may take more of what is free.
inline bool within_share(std::uint64_t own, std::uint64_t free) { return own / kTimesTheFree < free; }

}  // namespace meshgauge::server
