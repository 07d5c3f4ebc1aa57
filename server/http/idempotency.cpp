#include "server/http/idempotency.h"

#include <algorithm>

namespace meshgauge::server {
namespace {

constexpr std::size_t kMostKeyBytes = 255;

}  // namespace

std::optional<api::Problem> read_idempotency_key(const Head& head, std::string& key) {
  const auto count = std::count_if(head.headers.begin(), head.headers.end(),
                                   [](const auto& header) { return header.first == "idempotency-key"; });
  if (count == 0) return std::nullopt;
  key = head.header("idempotency-key");
  const bool visible = std::all_of(key.begin(), key.end(), [](char c) { return c > 0x20 && c < 0x7F; });
  if (count == 1 && !key.empty() && key.size() <= kMostKeyBytes && visible) return std::nullopt;
  return malformed("Idempotency-Key must be sent once, with 1 to 255 visible ASCII characters");
}

}  // namespace meshgauge::server
