#include "check/manifest/spelling.h"

#include <fnmatch.h>

#include <algorithm>
#include <cwctype>
#include <utility>

#include "api/base/text.h"
#include "api/base/utf8.h"
#include "check/files.h"
#include "check/manifest/glob.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

// Number of bytes of a blank at the beginning of the text: ASCII, no-break, of the blocks of punctuation and of CJK.
std::size_t blank_at(std::string_view text) {
  if (!text.empty() && std::string_view(" \t\r\n\v\f").find(text[0]) != std::string_view::npos) return 1;
  if (text.empty() || static_cast<unsigned char>(text[0]) < 0x80) return 0;
  const Character first = decode(text);
  const bool blank = first.code == 0xA0 || (first.code >= 0x2000 && first.code <= 0x200F) || first.code == 0x202F ||
                     first.code == 0x2060 || first.code == 0x3000 || first.code == 0xFEFF;
  return blank ? first.bytes : 0;
}

std::string_view without_leading_blanks(std::string_view text) {
  for (std::size_t n = blank_at(text); n > 0; n = blank_at(text)) text.remove_prefix(n);
  return text;
}

std::string_view without_trailing_blanks(std::string_view text) {
  while (!text.empty()) {
    std::size_t from = text.size() - 1;
    while (from > 0 && is_within_character(text[from])) --from;
    if (blank_at(text.substr(from)) != text.size() - from) break;
    text = text.substr(0, from);
  }
  return text;
}

std::string without_blanks(std::string_view name) {
  name = without_trailing_blanks(without_leading_blanks(name));
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return std::string(name);
  return std::string(name.substr(0, dot + 1)) + std::string(without_leading_blanks(name.substr(dot + 1)));
}

bool matches_by(const std::string& component, const std::string& name, int flags) {
  return fnmatch(component.c_str(), name.c_str(), FNM_NOESCAPE | flags) == 0;
}

void append(std::string& out, std::uint32_t code) {
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xC0U | (code >> 6U));
  } else if (code < 0x10000) {
    out += static_cast<char>(0xE0U | (code >> 12U));
    out += static_cast<char>(0x80U | ((code >> 6U) & 0x3FU));
  } else {
    out += static_cast<char>(0xF0U | (code >> 18U));
    out += static_cast<char>(0x80U | ((code >> 12U) & 0x3FU));
    out += static_cast<char>(0x80U | ((code >> 6U) & 0x3FU));
  }
  if (code >= 0x80) out += static_cast<char>(0x80U | (code & 0x3FU));
}

std::string lower(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const Character next = decode(text);
    if (next.bytes == 0) {
      out += text.front();
      text.remove_prefix(1);
    } else {
      append(out, std::towlower(next.code));
      text.remove_prefix(next.bytes);
    }
  }
  return out;
}

// A piece of a pattern: a letter that has another case, or anything else.
struct Piece {
  std::string text;
  std::string both;  // empty: it has one case
};

// "[a-z]" is also "[a-zA-Z]"; what is negated matches the other case anyway.
std::string bracket_of_both(const std::string& bracket) {
  const bool negated = bracket.size() > 1 && (bracket[1] == '!' || bracket[1] == '^');
  std::string other;
  for (const char c : bracket.substr(1, bracket.size() - 2)) {
    if (api::is_letter(c) || c == '-') other += api::is_letter(c) ? static_cast<char>(c ^ 0x20) : c;
  }
  while (other.starts_with('-')) other.erase(0, 1);
  while (other.ends_with('-')) other.pop_back();
  return negated || other.empty() ? "" : bracket.substr(0, bracket.size() - 1) + other + "]";
}

std::vector<Piece> pieces_of(std::string_view pattern) {
  std::vector<Piece> pieces;
  while (!pattern.empty()) {
    const Character next = decode(pattern);
    std::size_t bytes = std::max<std::size_t>(next.bytes, 1);
    std::string both;
    if (const std::size_t close = pattern.front() == '[' ? pattern.find(']', 2) : std::string_view::npos;
        close != std::string_view::npos) {
      bytes = close + 1;
      both = bracket_of_both(std::string(pattern.substr(0, bytes)));
    } else if (next.bytes > 0) {
      const std::uint32_t small = std::towlower(next.code), large = std::towupper(next.code);
      if (small != large) {
        both = "[";
        append(both, small);
        append(both, large);
        both += ']';
      }
    }
    pieces.push_back({std::string(pattern.substr(0, bytes)), std::move(both)});
    pattern.remove_prefix(bytes);
  }
  return pieces;
}

std::string pattern_of(std::span<const Piece> pieces) {
  std::string out;
  for (const Piece& piece : pieces) out += piece.both.empty() ? piece.text : piece.both;
  return out;
}

bool matches_all(const std::string& pattern, std::span<const std::vector<std::string>> paths) {
  std::vector<std::string> parts = components(pattern);
  if (!parts.empty() && parts.back() == "**") parts.emplace_back("*");
  return std::ranges::all_of(paths, [&](const auto& names) { return differences(parts, names) == 0U; });
}

}  // namespace

std::string spelling_key(std::string_view name) {
  std::string out = lower(without_blanks(name));
  std::ranges::replace(out, '\\', '/');
  return out;
}

std::optional<unsigned> differences(const std::string& component, const std::string& name) {
  if (matches_file(component, name)) return 0U;
  if (matches_by(component, name, FNM_PERIOD | FNM_CASEFOLD)) return of_upper_and_lower_case;
  const std::string plain_component = without_blanks(component), plain = without_blanks(name);
  if (!matches_by(plain_component, plain, FNM_CASEFOLD)) return std::nullopt;
  unsigned found = 0;
  if (!matches_by(plain_component, plain, FNM_CASEFOLD | FNM_PERIOD)) found |= of_leading_dot;
  if (!matches_by(plain_component, plain, 0)) found |= of_upper_and_lower_case;
  if (!matches_by(component, name, FNM_CASEFOLD)) found |= of_blanks_at_ends;
  return found;
}

std::optional<unsigned> differences(std::span<const std::string> parts, std::span<const std::string> names) {
  std::vector<std::optional<unsigned>> at(names.size() + 1);  // of the parts so far and the first names
  at[0] = 0U;
  for (const std::string& part : parts) {
    if (part == "**") {
      for (std::size_t j = 1; j < at.size(); ++j) {
        if (!at[j - 1]) continue;
        const unsigned here = *at[j - 1] | (names[j - 1].starts_with('.') ? unsigned{of_leading_dot} : 0U);
        if (!at[j] || here < *at[j]) at[j] = here;
      }
      continue;
    }
    for (std::size_t j = names.size(); j > 0; --j) {
      const auto more = at[j - 1] ? differences(part, names[j - 1]) : std::nullopt;
      at[j] = more ? std::optional(*at[j - 1] | *more) : std::nullopt;
    }
    at[0].reset();
  }
  return at.back();
}

std::string with_both_cases(std::string_view pattern, std::span<const std::string> paths) {
  constexpr std::size_t kMostPieces = 1000, kMostLetters = 100, kMostPaths = 100;
  std::vector<Piece> pieces = pieces_of(pattern);
  std::vector<std::vector<std::string>> names;
  for (const std::string& path : paths.first(std::min(paths.size(), kMostPaths))) names.push_back(components(path));
  if (pieces.size() > kMostPieces || !matches_all(pattern_of(pieces), names)) return "";
  std::size_t tried = 0;
  for (Piece& piece : pieces) {
    if (piece.both.empty() || ++tried > kMostLetters) continue;
    const std::string both = std::exchange(piece.both, "");
    if (!matches_all(pattern_of(pieces), names)) piece.both = both;
  }
  return pattern_of(pieces);
}

const std::string* Spellings::find(const fs::path& folder, const std::string& name) {
  const auto [known, is_new] = folders_.try_emplace(folder.string());
  if (is_new) {
    std::error_code failed;
    const fs::path place = folder.empty() ? fs::path(".") : folder;
    for (fs::directory_iterator it(place, failed), end; !failed && it != end; it.increment(failed)) {
      if (++looked_at_ > kMaxGlobEntries) break;
      std::string is = it->path().filename().string();
      std::string key = spelling_key(is);
      const auto [other, is_first] = known->second.try_emplace(std::move(key), is);
      if (!is_first && is < other->second) other->second = std::move(is);  // the same in each run
    }
  }
  const auto found = known->second.find(spelling_key(name));
  return found == known->second.end() ? nullptr : &found->second;
}

std::optional<fs::path> Spellings::other(const fs::path& path) {
  std::string text = path.string();
  std::ranges::replace(text, '\\', '/');
  const fs::path meant = fs::path(text).lexically_normal();
  const std::vector<fs::path> parts(meant.begin(), meant.end());
  std::vector<fs::path> folders{fs::path()};  // of each part
  std::error_code none;
  for (const fs::path& part : parts) {
    const fs::path exact = folders.back() / part;
    const std::string* name = fs::exists(exact, none) ? nullptr : find(folders.back(), part.string());
    if (!name && !fs::exists(exact, none)) break;
    folders.push_back(name ? folders.back() / *name : exact);
  }
  if (folders.size() > parts.size()) return folders.back() == path ? std::nullopt : std::optional(folders.back());
  if (meant.is_absolute()) return std::nullopt;
  for (std::size_t i = folders.size(); i-- > 0;) {  // a file of an archive that keeps its folders in its name
    fs::path rest;
    for (std::size_t j = i; j < parts.size(); ++j) rest /= parts[j];
    if (const std::string* name = find(folders[i], rest.string())) return folders[i] / *name;
  }
  return std::nullopt;
}

std::string spelling_hint(const fs::path& missing, Spellings& spellings) {
  const Utf8Locale utf8;
  const bool backslash = missing.string().find('\\') != std::string::npos;
  const auto found = spellings.other(missing);
  if (!found) return backslash ? "; folders are separated by '/'" : "";
  const std::string there = "there is " + shown_path(*found);
  if (backslash) return "; folders are separated by '/': " + there;
  if (found->string().find('\\') != std::string::npos)
    return "; " + there + ", with '\\' in its name: move it into its folder";
  const bool same = lower(found->string()) == lower(missing.string());
  return "; " + there + (same ? ": upper and lower case count" : ": blanks at the ends of names count");
}

}  // namespace meshgauge::check
