// The payloads of control.h: "<kind> <owner> <id>", owner and id in hexadecimal digits.
#include <algorithm>

#include "server/store/postgres/control.h"

namespace meshgauge::server::store {
namespace {

constexpr std::string_view kKinds = "wcxm";  // in the order of Signal::Kind
constexpr std::string_view kDigits = "0123456789abcdef";
constexpr std::size_t kLongest = 7000;  // PostgreSQL takes less than 8000 bytes

std::string hex_of(const std::string& text) {
  std::string hex;
  for (const char c : text) {
    hex += kDigits[static_cast<unsigned char>(c) >> 4];
    hex += kDigits[static_cast<unsigned char>(c) & 15];
  }
  return hex;
}

std::optional<std::string> text_of(std::string_view hex) {
  if (hex.size() % 2 != 0 || hex.find_first_not_of(kDigits) != std::string_view::npos) return std::nullopt;
  std::string text;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    text += static_cast<char>(kDigits.find(hex[i]) << 4 | kDigits.find(hex[i + 1]));
  }
  return text;
}

}  // namespace

std::string to_payload(const Signal& signal) {
  const std::string kind(1, kKinds[static_cast<std::size_t>(signal.kind)]);
  std::string payload = kind + " " + hex_of(signal.job.owner) + " " + hex_of(signal.job.id);
  return payload.size() <= kLongest ? payload : to_payload({Signal::Kind::missed, {}});
}

std::optional<Signal> signal_of(std::string_view payload) {
  const std::size_t second = payload.find(' ', 2);
  if (payload.size() < 3 || payload[1] != ' ' || second == std::string_view::npos) return std::nullopt;
  const std::size_t kind = kKinds.find(payload.front());
  auto owner = text_of(payload.substr(2, second - 2));
  auto id = text_of(payload.substr(second + 1));
  if (kind == std::string_view::npos || !owner || !id) return std::nullopt;
  return Signal{static_cast<Signal::Kind>(kind), {*std::move(owner), *std::move(id)}};
}

}  // namespace meshgauge::server::store
