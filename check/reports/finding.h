// Facts of a gate that did not pass, for viewers of findings: a place in a file, an identity, a description.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
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

// Returns 32 hex digits, made from the manifest's and the gate's name. They stay the same when the distance or the
// line changes, and differ between gates of one glob.
std::string fingerprint_of(const Gate& gate);

// What findings are about; viewers group them by it.
struct Rule {
  const char* id;    // in SARIF
  const char* name;  // in SARIF
  const char* slug;  // in Code Quality
  const char* what;
  const char* help;
};
std::span<const Rule> rules();

// Returns the index in rules() for a gate that did not pass. An expectation counts where the limits alone would give a
// better verdict; the distance before one of its sides, and that before the area.
std::size_t rule_of(const GateOutcome& outcome);

// Returns one line: "Gate 'bracket': the distance is at least 0.0968 mm, above the limit of 0.05 mm. Look at ..."
std::string description_of(const GateOutcome& outcome);

}  // namespace meshgauge::check
