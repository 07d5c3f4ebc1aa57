#include "api/formats/stl.h"

#include <algorithm>
#include <string>

#include "api/formats/stl_ascii.h"
#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

bool starts_with_word(std::string_view text, std::string_view lower_case) {
  return same_word(text.substr(0, lower_case.size()), lower_case);
}

// Returns the place of the first byte at the beginning that no text has; npos: there is none. The header of a binary
// file may be text, too, but its count and its normals contain such bytes.
std::size_t first_control(std::string_view text) {
  const std::string_view start = text.substr(0, 1024);
  const auto found =
      std::ranges::find_if(start, [](char c) { return static_cast<unsigned char>(c) < ' ' && !is_space(c); });
  return found == start.end() ? std::string_view::npos : static_cast<std::size_t>(found - start.begin());
}

// Returns true when a line begins with `word`.
bool has_line(std::string_view text, std::string_view word) {
  const char* const end = text.data() + text.size();
  for (const char* p = text.data(); p != end; p = next_line(p, end)) {
    p = skip_blanks(p, end);
    if (same_word(word_at(p, end), word)) return true;
  }
  return false;
}

// Refuses text that does not begin with "solid".
Error not_solid(const Source& source, std::string_view text) {
  const char* const end = text.data() + text.size();
  const char* const first = skip_spaces(after_mark(text), end);
  const std::string_view line(first, static_cast<std::size_t>(skip_line(first, end) - first));
  std::string remedy = "; it has no line that begins with 'facet': export it as STL";
  if (has_line(text, "facet")) {
    remedy = has_line(text, "solid") ? "; delete the lines before 'solid'" : "; begin the file with a line 'solid'";
  }
  return at_line(source, first, ErrorCode::unreadable_mesh,
                 "text, but line 1 is not 'solid': the file begins with " + in_quotes(line) + remedy);
}

}  // namespace

Result<ReadMesh> read_stl(const Source& source) {
  const std::string_view whole = source.text();
  const std::string_view text = whole.substr(0, length_without_padding(whole));
  if (text.empty() || is_binary_stl(source.bytes)) return read_binary_stl(source);
  if (const std::size_t control = first_control(text); control != std::string_view::npos) {
    if (!starts_with_word(text, "solid") || !has_line(text, "facet")) return read_binary_stl(source);
    return at_line(source, text.data() + control, ErrorCode::unreadable_mesh, "binary data in a text file");
  }
  const char* const end = text.data() + text.size();
  const char* const first = skip_spaces(after_mark(text), end);
  if (starts_with_word({first, end}, "solid")) return read_without_padding(source, read_ascii_stl);
  // Otherwise it may be the header of a binary file, cut before its count.
  const bool is_header = text.size() < whole.size() && std::ranges::none_of(text, is_newline);
  if (first == end || is_header) return read_binary_stl(source);
  return not_solid(source, text);
}

}  // namespace meshgauge::api
