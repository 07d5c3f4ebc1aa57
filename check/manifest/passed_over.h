// Finds the files that a glob seems to mean and does not match.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "check/manifest/glob.h"

namespace meshgauge::check {

struct PassedOver {
  std::string path;  // as Match::path
  unsigned why = 0;  // of Difference; not 0
};

struct PassedOverFiles {
  std::vector<PassedOver> files;  // in the order of their names; of a leading dot alone meshes by name
  bool all = true;                // false: kMaxGlobEntries or kMaxGlobMatches were passed, or it was interrupted
};

// Looks where glob() looks, and into folders whose names differ from the pattern in the same ways. What cannot be read
// is left out. Precondition: check_glob() accepts the pattern.
PassedOverFiles passed_over(const std::filesystem::path& folder, std::string_view pattern,
                            GlobConfines* confines = nullptr);

// Returns "passes over 'parts/X.STL', which it misses only by upper and lower case: ...", with what to do; for each
// kind of difference one. Files are named up to a few. Leading dots are left out.
std::vector<std::string> passed_over_in_words(std::string_view pattern, const std::vector<PassedOver>& files);

// Returns "'parts/*.stl' passes over 2 files whose names begin with a dot: ...". Empty: there are none.
std::string hidden_in_words(std::string_view pattern, const PassedOverFiles& found);

}  // namespace meshgauge::check
