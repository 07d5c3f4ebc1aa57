// A manifest as it is written: its settings are read and checked, its globs stand as they are. Nothing is looked up in
// a file system.
#pragma once

#include <string_view>
#include <vector>

#include "check/gate.h"
#include "check/manifest/mistake.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxNameBytes = 200;
inline constexpr std::size_t kMaxPathBytes = 4096;

// One entry of `gates`, with the defaults in it. `name` and `baseline` pass check_template(), `candidate` check_glob();
// one with a mistake in it is empty.
struct Entry {
  Place place;
  Written name;
  Written candidate;
  Written baseline;
  bool unmatched_ignored = false;  // a baseline without a candidate is no mistake
  Gate gate;                       // the settings alone
};

// What can be read, whatever mistakes there are besides.
std::vector<Entry> read_manifest(std::string_view text, Mistakes& mistakes);

}  // namespace meshgauge::check
