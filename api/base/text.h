// Numbers and words of text: parsed within [p, end), and shown in messages.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

namespace meshgauge::api {

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline bool is_blank(char c) { return c == ' ' || c == '\t'; }
inline bool is_newline(char c) { return c == '\n' || c == '\r'; }
inline bool is_space(char c) { return is_blank(c) || is_newline(c) || c == '\v' || c == '\f'; }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Whether the text has this many lower-case hex digits, and nothing else.
inline bool is_lower_hex(std::string_view text, std::size_t digits) {
  return text.size() == digits && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

inline char lowered(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

inline std::string lower_case(std::string text) {
  for (char& c : text) c = lowered(c);
  return text;
}

// Returns the place after the byte order mark of UTF-8, if the text begins with it.
inline const char* after_mark(std::string_view text) {
  return text.data() + (text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
}

inline const char* skip_blanks(const char* p, const char* end) {
  while (p != end && is_blank(*p)) ++p;
  return p;
}

inline const char* skip_spaces(const char* p, const char* end) {
  while (p != end && is_space(*p)) ++p;
  return p;
}

inline const char* skip_line(const char* p, const char* end) {
  while (p != end && !is_newline(*p)) ++p;
  return p;
}

// Skips the rest of the line and its end: \n, \r\n or \r.
inline const char* next_line(const char* p, const char* end) {
  p = skip_line(p, end);
  if (p != end && *p == '\r') ++p;
  if (p != end && *p == '\n') ++p;
  return p;
}

// Returns the characters up to the next space.
inline std::string_view word_at(const char* p, const char* end) {
  const char* q = p;
  while (q != end && !is_space(*q)) ++q;
  return {p, static_cast<std::size_t>(q - p)};
}

// Compares without regard to case, for ASCII letters only, in any locale.
inline bool same_word(std::string_view text, std::string_view lower_case) {
  if (text.size() != lower_case.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (lowered(text[i]) != lower_case[i]) return false;
  }
  return true;
}

// Returns strtod's value of a number that from_chars reports as out of range: infinity, a denormal or zero.
double out_of_range_value(const char* first, const char* last);

// Parses the longest decimal number at p, correctly rounded: bit-equal to strtod in the C locale. Returns the place
// after it; nullptr: no number. "nan", "inf" and numbers beyond the range give a non-finite value; the caller refuses
// it, and checks the characters after the number.
inline const char* parse_number(const char* p, const char* end, double& value) {
  // strtod takes one leading '+', from_chars takes none.
  if (p != end && *p == '+' && ++p != end && (*p == '-' || *p == '+')) return nullptr;
  const auto [next, fault] = std::from_chars(p, end, value);
  if (fault == std::errc{}) return next;
  if (fault != std::errc::result_out_of_range) return nullptr;
  value = out_of_range_value(p, next);
  return next;
}

// Returns the text without surrounding blanks and line ends.
inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

inline void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

// Parses an integer with an optional '-'. Returns the place after it; nullptr: no integer. A value of more digits than
// 64 bits hold becomes some value of at least 2^58 in magnitude.
inline const char* parse_integer(const char* p, const char* end, std::int64_t& value) {
  const bool negative = p != end && *p == '-';
  p += negative;
  if (p == end || !is_digit(*p)) return nullptr;
  constexpr std::int64_t kSaturated = std::int64_t{1} << 58;
  std::int64_t magnitude = 0;
  for (; p != end && is_digit(*p); ++p) {
    magnitude = magnitude < kSaturated ? magnitude * 10 + (*p - '0') : kSaturated;
  }
  value = negative ? -magnitude : magnitude;
  return p;
}

// Returns "one, two, three", or with " or " before the last "one, two or three". `words`: texts.
template <class Words>
std::string listed(const Words& words, std::string_view before_last = ", ") {
  std::string list;
  for (auto word = std::begin(words); word != std::end(words); ++word) {
    if (word != std::begin(words)) list.append(std::next(word) == std::end(words) ? before_last : ", ");
    list.append(*word);
  }
  return list;
}

// Returns foreign text for a message: at most `longest` characters, printable ASCII only. in_quotes() puts at most
// 32 characters into single quotes.
std::string printable(std::string_view text, std::size_t longest);
std::string in_quotes(std::string_view text);

// Percent-encodes every byte except letters, digits and those in `kept` (RFC 3986).
std::string percent_encoded(std::string_view bytes, std::string_view kept);

}  // namespace meshgauge::api
