// UTF-8, for what reports will carry: JSON and XML take no other bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace meshgauge::check {

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  // 0: not UTF-8
};

// The first character of a text that is not empty. UTF-8 is well-formed: the shortest form, no surrogate, at most
// U+10FFFF (RFC 3629).
Character decode(std::string_view text);

// Where the first byte stands that is not UTF-8; npos: nowhere.
std::size_t find_not_utf8(std::string_view text);

inline bool is_utf8(std::string_view text) { return find_not_utf8(text) == std::string_view::npos; }

// Of ASCII alone: what no name or label may hold.
inline bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }
std::size_t find_control(std::string_view text);  // the first; npos: there is none

}  // namespace meshgauge::check
