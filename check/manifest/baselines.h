// Copies candidates over their baselines: --update-baselines, and --dry-run, which only reports.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "check/gate.h"
#include "check/manifest/mistake.h"
#include "engine/result.h"

namespace meshgauge::check {

struct Update {
  enum class Kind { create, replace, none };  // none: both have the same bytes

  std::string gate;
  std::filesystem::path candidate;
  std::filesystem::path baseline;
  Kind kind = Kind::none;
};

struct Updates {
  std::vector<Update> updates;    // each baseline once
  std::vector<Mistake> mistakes;  // if any: nothing is written
};

// Plans the updates and writes nothing. `gates`: from gates_of(..., Baselines::may_be_missing), or from flags.
// Mistakes: a candidate that is missing, is no mesh, lacks a group of the gate or is a glTF of several files; two
// candidates for one baseline; a suffix that differs from the candidate's; a baseline that is a symbolic link, or lies
// behind one that leads out of the manifest's folder (without a manifest: the current folder).
Updates plan_updates(const std::vector<Gate>& gates);

// Carries out all updates or none, as far as the file system allows: copies everything first, then renames. A
// concurrent reader sees the old or the new baseline, never a part. Precondition: no mistakes.
Result<Done> carry_out(const Updates& updates);

// "create baselines/x.stl from build/x.stl", for a dry run or a report.
std::string to_string(const Update& update);

}  // namespace meshgauge::check
