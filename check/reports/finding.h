// What viewers of findings want of a gate that did not pass: a place in a file, an identity, a description.
#pragma once

#include <filesystem>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// The gate's line of the manifest. Flags have none: then the candidate, and its first line, since viewers ask for one.
struct Location {
  std::filesystem::path file;
  int line = 1;
};
Location location_of(const Gate& gate);

// The path of a URI (RFC 3986): shortened lexically, every byte percent-encoded but the unreserved ones and '/', so
// that a name may be of any bytes.
std::string uri_path(const std::filesystem::path& file);

// 32 hex digits of the manifest's and the gate's name. A finding stays the same one while its distance or its line
// changes, and another one than its neighbours of the same glob and line.
std::string fingerprint_of(const Gate& gate);

// On one line: "Gate 'bracket': the distance is at least 0.0968 mm, above the limit of 0.05 mm. Look at ..."
std::string description_of(const GateOutcome& outcome);

}  // namespace meshgauge::check
