// gates.yaml: what to check, as a file beside the parts. Its keys, with examples, are in gates.schema.json.
#pragma once

#include <filesystem>
#include <vector>

#include "check/gate.h"
#include "check/manifest/expand.h"
#include "check/manifest/mistake.h"

namespace meshgauge::check {

struct Gates {
  std::vector<Gate> gates;
  std::vector<Mistake> mistakes;  // any: nothing is to be measured
};

// Reads a manifest and looks up the files of the gates in `only`; says everything that is wrong, not the first alone.
// Paths in it are relative to its folder. Limits: kMaxYamlBytes, kMaxYamlDepth and kMaxYamlNodes of the file
// (yaml_tree.h), kMaxGates, and kMaxGlobEntries for each glob.
Gates gates_of(const std::filesystem::path& manifest, Baselines baselines = Baselines::must_exist,
               const Selection& only = {});

}  // namespace meshgauge::check
