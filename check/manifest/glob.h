// Finds files by a pattern: *, ? and [..] within a name, as in fnmatch, and ** for any number of folders.
#pragma once

#include <locale.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/descriptor.h"
#include "api/base/whole_file.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxGlobEntries = 1'000'000;  // looked at by one pattern: "/**" would not end for hours
inline constexpr std::size_t kMaxGlobMatches = 10'000;

bool is_glob(std::string_view pattern);

// Whether a pattern without '**' matches all of `text`. Dots and slashes are ordinary characters.
bool matches(const std::string& pattern, const std::string& text);

// Checks a pattern. The Error is the end of a sentence ("has a '[' that is not closed ...").
Result<Done> check_glob(std::string_view pattern);

// What the globs of a manifest may do for a client that is not trusted: they list folders below one that is held,
// whatever is put in their places meanwhile. A glob that meets a symbolic link to a folder is an error.
struct GlobConfines {
  api::BaseFolder folder;                       // of the manifest, where patterns begin; held
  Interrupted interrupted = never_interrupted;  // polled for each entry of a folder
  std::size_t entries_left = kMaxGlobEntries;   // that all globs together may look at
};

struct Match {
  std::string path;  // as the pattern is written: relative to the folder, or absolute
  std::string
      dir;  // folder of the file below the pattern's part before the first wildcard; empty: the file is directly there
};

// Returns the matching files in the order of their names. '?' and '[..]' stand for one character of UTF-8. A wildcard
// does not match a leading dot. A link to a file is a file; ** does not follow links to folders, which may form a
// circle. Errors: a folder that cannot be read, or a limit above. Precondition: check_glob() accepts the pattern.
Result<std::vector<Match>> glob(const std::filesystem::path& folder, std::string_view pattern,
                                GlobConfines* confines = nullptr);

// The parts below are for what else looks files up by patterns.

// A folder to list, by this path while it is held.
struct ListedFolder {
  std::filesystem::path path;
  Descriptor held{};
};

// `written`: below `folder`, or absolute; empty: the folder itself. Errors: invalid_request where it is confined, and
// no folder, or behind a symbolic link.
Result<ListedFolder> listed_folder(const std::filesystem::path& folder, const std::string& written,
                                   const GlobConfines* confines);

// Makes fnmatch() in this thread treat characters as UTF-8 while it lives, whatever the process's locale.
class Utf8Locale {
 public:
  Utf8Locale();
  ~Utf8Locale();
  Utf8Locale(const Utf8Locale&) = delete;
  Utf8Locale& operator=(const Utf8Locale&) = delete;

 private:
  locale_t locale_;
  locale_t before_{};
};

// Returns what stands between the slashes. Several '**' in a row are one.
std::vector<std::string> components(std::string_view pattern);

// Whether every bracket of the component is closed.
bool has_closed_brackets(std::string_view component);

// Whether a wildcard may match the name; a leading dot only a dot. Precondition: a Utf8Locale lives.
bool matches_file(const std::string& component, const std::string& name);

std::string joined(const std::string& folder, const std::string& name);

}  // namespace meshgauge::check
