// Facts of a gate that did not pass, for viewers of findings: a place in a file, an identity, a description.
#pragma once

#include <filesystem>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// The gate's line in the manifest. Without a manifest: line 1 of the candidate, since viewers need a place.
struct Location {
  std::filesystem::path file;
  int line = 1;
};
Location location_of(const Gate& gate);

// Returns the path of a URI (RFC 3986), shortened lexically. Every byte except unreserved ones and '/' is
// percent-encoded.
std::string uri_path(const std::filesystem::path& file);

// Whether the limit of the area alone is exceeded.
bool fails_by_area(const GateOutcome& outcome);

// Whether a limit of one side is exceeded, and none of the distance on both.
bool fails_by_zone(const GateOutcome& outcome);

// Returns 32 hex digits, made from the manifest's and the gate's name. They stay the same when the distance or the
// line changes, and differ between gates of one glob.
std::string fingerprint_of(const Gate& gate);

// Whether the gate does not pass for what it expects of the candidate, and its distance alone would give a better
// verdict.
bool fails_by_expectation(const GateOutcome& outcome);

// Returns one line: "Gate 'bracket': the distance is at least 0.0968 mm, above the limit of 0.05 mm. Look at ..."
std::string description_of(const GateOutcome& outcome);

}  // namespace meshgauge::check
