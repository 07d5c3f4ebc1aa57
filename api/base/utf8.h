// UTF-8, which reports in JSON and XML require.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace meshgauge {

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  // 0: not UTF-8
};

// Decodes the first character. Precondition: `text` is not empty. Accepts the shortest form alone, no surrogates, at
// most U+10FFFF (RFC 3629).
Character decode(std::string_view text);

// Position of the first byte that is not UTF-8; npos: there is none.
std::size_t find_not_utf8(std::string_view text);

inline bool is_utf8(std::string_view text) { return find_not_utf8(text) == std::string_view::npos; }

// Whether `c` continues a character: a text may not be cut before it.
inline bool is_within_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80; }

// Whether `c` is an ASCII control character, which names and labels must not contain.
inline bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }
std::size_t find_control(std::string_view text);  // position of the first one; npos: there is none

// Whether a character is invisible or forbidden in XML 1.0: controls, line separators, marks of direction,
// noncharacters.
bool is_hidden(std::uint32_t code);

}  // namespace meshgauge
