// Names of files that differ only in what people and other systems take for the same: case, blanks, separators, a dot.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

namespace meshgauge::check {

// Differences between a pattern and a name. Several may come together.
enum Difference : unsigned {
  of_upper_and_lower_case = 1,
  of_blanks_at_ends = 2,  // at an end of a name, or behind its last dot
  of_backslashes = 4,     // where '/' separates folders
  of_leading_dot = 8,     // which no wildcard matches
};

// Preconditions of all functions: a Utf8Locale lives.

// Returns the name in lower case and without blanks at its ends, each '\' as '/'.
std::string spelling_key(std::string_view name);

// Returns the differences because of which the component of a pattern does not match the name: 0 if it does, nullopt
// if it would not without them either.
std::optional<unsigned> differences(const std::string& component, const std::string& name);

// The same for a path. `parts`: components of a pattern.
std::optional<unsigned> differences(std::span<const std::string> parts, std::span<const std::string> names);

// Returns the pattern with both cases of as few letters as let it match all `paths`: "parts/*.[sS][tT][lL]". Empty:
// there is none.
std::string with_both_cases(std::string_view pattern, std::span<const std::string> paths);

// Finds paths that exist in another spelling. Reads each folder once.
class Spellings {
 public:
  // Returns the path that exists and differs from `path`, which does not. nullopt: there is none.
  std::optional<std::filesystem::path> other(const std::filesystem::path& path);

 private:
  using Names = std::unordered_map<std::string, std::string>;  // as spelling_key() -> as it is

  const std::string* find(const std::filesystem::path& folder, const std::string& name);

  std::unordered_map<std::string, Names> folders_;
  std::size_t looked_at_ = 0;
};

// Returns the end of a sentence that says that a file does not exist: "; there is 'X.STL': upper and lower case count".
// Empty: no other spelling exists, and `missing` has no backslash.
std::string spelling_hint(const std::filesystem::path& missing, Spellings& spellings);

}  // namespace meshgauge::check
