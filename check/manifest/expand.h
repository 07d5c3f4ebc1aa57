// From what a manifest says to the gates that it means: its globs looked up, its names filled in, its files found.
#pragma once

#include <filesystem>
#include <vector>

#include "check/gate.h"
#include "check/manifest/manifest_text.h"
#include "check/manifest/mistake.h"
#include "check/selection.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxGates = 10'000;

// `may_be_missing` is for what writes the baselines.
enum class Baselines { must_exist, may_be_missing };

// `only`: of other gates no file has to be there. They are returned as well.
struct Lookup {
  Baselines baselines = Baselines::must_exist;
  const Selection& only;
};

// Mistakes, at the entry's candidate, baseline or name: a glob that finds nothing; a file that is missing or none; a
// candidate that is its own baseline, by whatever name; a baseline with a placeholder that is the same for two
// candidates (without one it is meant so: many candidates, one baseline); a name that two gates have; a file that by
// its name would be the baseline of a glob's candidate, and is that of no gate: its candidate was not written. The last
// is none for what writes the baselines, and is not looked for with `only`.
std::vector<Gate> expand(const std::vector<Entry>& entries, const std::filesystem::path& manifest, const Lookup& lookup,
                         Mistakes& mistakes);

}  // namespace meshgauge::check
