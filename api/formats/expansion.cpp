#include "api/formats/expansion.h"

#include <algorithm>

namespace meshgauge::api {

std::size_t expansion_limit(std::size_t compressed_bytes, const ReadLimits& limits) {
  constexpr std::size_t kFreeOfRatio = std::size_t{64} << 20U;
  constexpr std::size_t kMostRatio = 200;
  // min() keeps the product within 64 bits.
  const std::size_t by_ratio = kMostRatio * std::min(compressed_bytes, kFreeOfRatio * kMostRatio);
  return std::min(limits.max_expanded_bytes, std::max(kFreeOfRatio, by_ratio));
}

Error expands_too_far(std::string_view part, std::size_t limit, std::size_t compressed_bytes, std::string_view kind) {
  return about(part, ErrorCode::too_large,
               "expands to more than " + std::to_string(limit) + " bytes, from " + std::to_string(compressed_bytes) +
                   " bytes of " + std::string(kind));
}

}  // namespace meshgauge::api
