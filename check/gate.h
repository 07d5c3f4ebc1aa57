// One gate: two files and how far they may be apart. The central type of `meshgauge check`.
//
//   gates.yaml -> gates_of (settings, globs, names) -> Gate ... -> run (here, or by a service) -> GateOutcome ...
//   -> Report -> terminal, JSON, JUnit, SARIF, Markdown, HTML, exit code
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/compare/mesh_file.h"
#include "api/options/expectations.h"
#include "api/options/request.h"
#include "check/manifest/mistake.h"
#include "engine/result.h"

namespace meshgauge::check {

using api::Expectations;
using api::LengthUnit;

// `candidate` is mesh a, `baseline` mesh b: a_to_b is from the candidate to the baseline.
struct Gate {
  std::string name;                 // unique in a run
  std::filesystem::path candidate;  // as a user would write it: relative to the current folder where possible; empty:
                                    // there is none, as a defect says
  std::filesystem::path baseline;
  std::shared_ptr<const api::Pipes> pipes;    // what was sent by those of the two that are pipes; null: both are files
  std::shared_ptr<const api::Copies> copies;  // of a baseline of a revision, "main:lid.stl"; null: it is a file
  // What is measured, and the limits, of which one is given at least. The time limit is that of the whole gate.
  api::Request request;
  bool warn_only = false;  // fail and undecided are reported and do not count
  bool cloud = false;      // the candidate may be a point cloud; an XYZ always may
  std::string manifest;    // manifest that contains the gate, for reports that point at a line; empty: given by flags
  int line = 0;            // 1-based
  // Why it cannot be measured, found before anything is: a file is missing, or is none. Other gates are measured.
  std::vector<Mistake> defects{};
  std::vector<std::string> notes{};  // sentences of the manifest without full stop: files that a glob passes over
  std::shared_ptr<const api::Confines> confines{};  // what may be read of its files; null: any file
};

// Returns the options with limits in the unit of the result. `document`: the result of a comparison, which has the
// diagonal that shares are of; without it such limits are NaN.
api::ComparisonOptions options_in(const Gate& gate, const nlohmann::ordered_json& document);

// Returns the error of a comparison with every 'a' in its message replaced by the gate's candidate and every 'b' by its
// baseline.
Error with_files(Error error, const Gate& gate);

// Whether the limits are shares of the diagonal of the baseline's bounding box: 0.01 is one percent.
inline bool is_of_diagonal(const Gate& gate) { return gate.request.options.units.limit_of_diagonal; }

}  // namespace meshgauge::check
