// Flags of `meshgauge check`, and the gates that they select.
#pragma once

#include <string>
#include <vector>

#include "check/gate.h"
#include "check/manifest/manifest.h"
#include "check/outcome.h"
#include "cli/option_flags.h"
#include "engine/result.h"

namespace CLI {
class App;
}

namespace meshgauge::cli {

struct CheckFlags {
  std::vector<std::string> files;  // candidate and baseline, or a manifest
  OptionFlags options;
  bool cloud = false;
  std::vector<std::string> only;
  double jobs = 0;
  std::string undecided;

  std::string json, junit, sarif, markdown, comment, code_quality, html, pictures, deviation, history;
  std::string annotations;  // a file, or "-": standard error
  bool no_annotations = false;
  std::string since;  // the report of an earlier run
  bool map_normals = false;
  bool quiet = false;
  bool no_colour = false;

  std::string server, key_file, ca_file;
  bool key_in_clear = false;
  bool init = false;   // `files`: a folder, or none
  std::string update;  // of --update-baselines: "differing", "all", "missing"; empty: not given
  bool dry_run = false;
  bool is_against = false;
  std::string against;  // with `is_against`: a git revision, perhaps empty
};

// Values of CheckFlags::update.
inline constexpr const char* kUpdateDiffering = "differing";
inline constexpr const char* kUpdateAll = "all";
inline constexpr const char* kUpdateMissing = "missing";

void declare(CLI::App& command, CheckFlags& flags);

// With --against, a mesh that is named alone is compared with the file of the same path.
void take_own_baseline(CheckFlags& flags);

// The gates of the manifest or of the two files, selected by --only, or all mistakes at once.
struct Asked {
  std::vector<check::Gate> gates;
  std::vector<check::Mistake> mistakes;      // if any: nothing is measured
  std::string manifest;                      // manifest with the mistakes; empty: they are about flags
  std::vector<std::string> explanation{};    // further lines for the terminal
  std::vector<check::OpenBaselines> open{};  // of the manifest, for --against
};
Asked gates_asked(const CheckFlags& flags);

// Where annotations are written: as CheckFlags::annotations; without the flag to standard error where GITHUB_ACTIONS is
// "true". Empty: nowhere.
std::string place_of_annotations(const CheckFlags& flags);

check::Undecided undecided_rule(const CheckFlags& flags);

}  // namespace meshgauge::cli
