#include "check/utf8.h"

#include <algorithm>
#include <cstdint>

namespace meshgauge::check {
namespace {

// What a first byte announces: how many bytes follow, its own bits, and the smallest number that needs so many.
struct Lead {
  std::size_t following;
  std::uint32_t bits;
  std::uint32_t smallest;
};

Lead lead(unsigned char byte) {
  if (byte < 0x80) return {0, byte, 0};
  if (byte >= 0xC0 && byte < 0xE0) return {1, byte & 0x1FU, 0x80};
  if (byte >= 0xE0 && byte < 0xF0) return {2, byte & 0x0FU, 0x800};
  if (byte >= 0xF0 && byte < 0xF8) return {3, byte & 0x07U, 0x10000};
  return {0, 0, 1};  // nothing is that small
}

// How many bytes the character at `i` has; 0: it is none.
std::size_t length_at(std::string_view text, std::size_t i) {
  auto [following, code, smallest] = lead(static_cast<unsigned char>(text[i]));
  if (text.size() - i <= following) return 0;
  for (std::size_t k = 1; k <= following; ++k) {
    const auto byte = static_cast<unsigned char>(text[i + k]);
    if ((byte & 0xC0U) != 0x80U) return 0;
    code = code << 6 | (byte & 0x3FU);
  }
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  return code < smallest || code > 0x10FFFF || surrogate ? 0 : following + 1;
}

}  // namespace

std::size_t find_not_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = length_at(text, i);
    if (length == 0) return i;
    i += length;
  }
  return std::string_view::npos;
}

std::size_t find_control(std::string_view text) {
  const auto found = std::find_if(text.begin(), text.end(), is_control);
  return found == text.end() ? std::string_view::npos : static_cast<std::size_t>(found - text.begin());
}

}  // namespace meshgauge::check
