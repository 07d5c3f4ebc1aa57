// Helpers for HTTP grammar (RFC 9110 section 5.6), independent of the locale.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

#include "api/base/text.h"
#include "api/base/utf8.h"

namespace meshgauge::server {

using api::is_digit;
using api::is_letter;

inline std::string lower(std::string_view text) { return api::lower_case(std::string(text)); }

inline std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

inline bool is_token_char(char c) {
  if (is_digit(c) || is_letter(c)) return true;
  return c != '\0' && std::strchr("!#$%&'*+-.^_`|~", c) != nullptr;
}

inline bool is_token(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), is_token_char);
}

// True: visible ASCII, space, tab and bytes beyond ASCII only. A control character could end a line for another parser.
inline bool is_field_text(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c == '\t' || !is_control(c); });
}

// Removes the text before the first `separator`, and the separator, from `rest`; returns that text. Without a
// separator: all of `rest`.
inline std::string_view next(std::string_view& rest, std::string_view separator) {
  const std::size_t end = rest.find(separator);
  const std::string_view item = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + separator.size());
  return item;
}

}  // namespace meshgauge::server
