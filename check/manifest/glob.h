// Files by a pattern: *, ?, [..] within a name, as the shell has them (fnmatch), and ** for any folders between.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxGlobEntries = 1'000'000;  // looked at by one pattern: "/**" would not end for hours
inline constexpr std::size_t kMaxGlobMatches = 10'000;

bool is_glob(std::string_view pattern);

// Whether a pattern without '**' matches all of a text, in which neither a dot nor a slash is anything special.
bool matches(const std::string& pattern, const std::string& text);

// What is wrong with a pattern, behind the subject ("has a '[' that is not closed ...").
Result<Done> check_glob(std::string_view pattern);

struct Match {
  std::string path;  // as the pattern is written: relative to the folder, or absolute
  std::string dir;   // its folder below the part of the pattern before the first wildcard; empty: it lies right there
};

// The files that match, in the order of their names; '?' and '[..]' stand for one character of UTF-8. As in the shell a
// wildcard does not match a dot at the start of a name. A link to a file is a file; ** does not follow links to
// folders, which may lead in a circle. An error: a folder that cannot be read, or a limit above. Precondition:
// check_glob() has no objection.
Result<std::vector<Match>> glob(const std::filesystem::path& folder, std::string_view pattern);

}  // namespace meshgauge::check
