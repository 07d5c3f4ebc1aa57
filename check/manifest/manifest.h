// Reads gates.yaml: which files to check, and how. gates.schema.json has its keys with examples.
#pragma once

#include <filesystem>
#include <vector>

#include "check/gate.h"
#include "check/manifest/expand.h"
#include "check/manifest/mistake.h"

namespace meshgauge::check {

struct Gates {
  std::vector<Gate> gates;
  std::vector<Mistake> mistakes;  // if any: nothing is measured; they have the defects of the gates as well
};

// Returns all that is wrong: the mistakes or, without any, the defects of the gates: "gate 'x': the baseline ...".
std::vector<Mistake> defects_of(const Gates& read);

// Reads a manifest and looks up the files of the gates in `only`. Reports every mistake, not only the first. Paths in
// it are relative to its folder. A file that is missing is a defect of its gate alone. Limits: kMaxYamlBytes,
// kMaxYamlDepth and kMaxYamlNodes (yaml_tree.h), kMaxGates, and kMaxGlobEntries for each glob.
Gates gates_of(const std::filesystem::path& manifest, Baselines baselines = Baselines::must_exist,
               const Selection& only = {});

}  // namespace meshgauge::check
