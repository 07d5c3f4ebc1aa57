// What `check` makes of the meshes of a run beside the verdicts: pictures for the HTML report, and deviation maps.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "check/gate.h"
#include "check/html/gallery.h"
#include "check/outcome.h"
#include "check/run/meshes.h"
#include "cli/places.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::cli {

// --deviation: a file for two meshes given by flags, a folder for the gates of a manifest.
class DeviationMaps {
 public:
  // `where`: empty for none. Makes the folder; an Error when that, or the name of a file, cannot be, and when a file is
  // one of `places`, which gets all of them.
  static Result<DeviationMaps> open(const std::string& where, bool of_manifest, const std::vector<check::Gate>& gates,
                                    Places& places);

  bool wanted() const { return !files_.empty(); }
  const std::filesystem::path& file_of(std::size_t gate) const { return files_.at(gate); }

 private:
  std::vector<std::filesystem::path> files_;  // one a gate
};

// Thread safe where check::Watch asks for it.
class CheckExtras {
 public:
  // `meshes` were told of turns() for it, beside those of others.
  static unsigned turns(bool pictures, const DeviationMaps& maps) {
    return (pictures ? 1U : 0U) + (maps.wanted() ? 1U : 0U);
  }
  // `threads` of one map; `processors`: all that there are, for pictures when the gates have ended.
  CheckExtras(std::shared_ptr<check::Meshes> meshes, bool pictures, DeviationMaps maps, unsigned threads,
              unsigned processors);

  void ended(const check::GateOutcome& outcome);                                       // Watch::ended
  void after(std::size_t place, const check::GateOutcome& outcome, Control& control);  // Watch::after
  std::vector<check::GatePicture> pictures(const check::Report& report,
                                           const Interrupted& interrupted);  // empty: not wanted

  const std::vector<std::string>& problems() const { return problems_; }  // when the run is over

 private:
  Error no_map(std::size_t place, const std::string& why) const;
  Result<Done> write_map(std::size_t place, const check::GateOutcome& outcome, Control& control);

  const std::shared_ptr<check::Meshes> meshes_;
  const DeviationMaps maps_;
  const unsigned threads_;
  std::optional<check::Gallery> gallery_;
  std::mutex mutex_;  // guards what follows
  std::vector<std::string> problems_;
};

}  // namespace meshgauge::cli
