// Expands the entries of a manifest to gates: looks up globs, fills in names, checks files.
#pragma once

#include <filesystem>
#include <vector>

#include "check/gate.h"
#include "check/manifest/manifest_text.h"
#include "check/manifest/mistake.h"
#include "check/selection.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxGates = 10'000;

// `may_be_missing` is for --update-baselines.
enum class Baselines { must_exist, may_be_missing };

// `only`: files of other gates need not exist; these gates are returned as well.
struct Lookup {
  Baselines baselines = Baselines::must_exist;
  const Selection& only;
};

// Returns the gates. Adds mistakes at the entry's candidate, baseline or name: a glob without matches; a missing or
// unusable file; a candidate that is its own baseline; a baseline with a placeholder that is the same for two
// candidates; two gates of one name; a baseline that matches a glob's template and has no candidate. The last is
// skipped for --update-baselines and with `only`.
std::vector<Gate> expand(const std::vector<Entry>& entries, const std::filesystem::path& manifest, const Lookup& lookup,
                         Mistakes& mistakes);

}  // namespace meshgauge::check
