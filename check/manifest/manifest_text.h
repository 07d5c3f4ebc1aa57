// Reads the text of a manifest and checks its settings. Globs stay as they are; no file is looked up.
#pragma once

#include <string_view>
#include <vector>

#include "check/gate.h"
#include "check/manifest/mistake.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxNameBytes = 200;
inline constexpr std::size_t kMaxPathBytes = 4096;

// One entry of `gates`, with the defaults filled in. `name` and `baseline` pass check_template(), `candidate` passes
// check_glob(); a field with a mistake is empty.
struct Entry {
  Place place;
  Written name;
  Written candidate;
  Written baseline;
  bool unmatched_ignored = false;  // a baseline without a candidate is not a mistake
  Gate gate;                       // only its settings are filled in
};

// Returns the entries that could be read, and adds the mistakes of the others.
std::vector<Entry> read_manifest(std::string_view text, Mistakes& mistakes);

}  // namespace meshgauge::check
