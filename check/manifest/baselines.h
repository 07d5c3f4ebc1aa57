// New baselines from candidates that a person has looked at: --update-baselines, and --dry-run, which only says so.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "check/gate.h"
#include "check/manifest/mistake.h"
#include "engine/result.h"

namespace meshgauge::check {

struct Update {
  enum class Kind { create, replace, none };  // none: the bytes are the same

  std::string gate;
  std::filesystem::path candidate;
  std::filesystem::path baseline;
  Kind kind = Kind::none;
};

struct Updates {
  std::vector<Update> updates;    // each baseline once
  std::vector<Mistake> mistakes;  // any: nothing is to be written
};

// Looks, and writes nothing. `gates` as by gates_of(..., Baselines::may_be_missing), or from flags. Mistakes: a
// candidate that is missing, no mesh or a glTF of several files; two candidates for one baseline; another suffix than
// the candidate's, which would be a wrong name for its bytes; a baseline that is a symbolic link, or lies behind one
// that leads out of the folder of the manifest (of the current one, when there is none): what is there is not this
// project's.
Updates plan_updates(const std::vector<Gate>& gates);

// All or nothing, as far as a file system has it: everything is copied beside its place before the first is renamed
// into it. Who reads a baseline meanwhile sees the old one or the new one. Precondition: no mistakes.
Result<Done> carry_out(const Updates& updates);

// "create baselines/x.stl from build/x.stl": for a dry run, or after it is done.
std::string to_string(const Update& update);

}  // namespace meshgauge::check
