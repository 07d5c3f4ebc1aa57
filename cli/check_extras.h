// Makes pictures for the HTML report and deviation maps of the meshes of a run.
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

// Files of --deviation: one file for two meshes given by flags, a folder for the gates of a manifest.
class DeviationMaps {
 public:
  // Creates the folder and adds all files to `places`. `where`: empty: no maps. Errors: the folder or a file cannot
  // be created, or a file is already one of `places`.
  static Result<DeviationMaps> open(const std::string& where, bool of_manifest, const std::vector<check::Gate>& gates,
                                    Places& places);

  bool wanted() const { return !files_.empty(); }
  const std::filesystem::path& file_of(std::size_t gate) const { return files_.at(gate); }

 private:
  std::vector<std::filesystem::path> files_;  // one per gate
};

// after() is thread safe; the others are for the thread that runs the gates.
class CheckExtras {
 public:
  // Number of turns that `meshes` must have for it, beside those of others.
  static unsigned turns(bool pictures, const DeviationMaps& maps) {
    return (pictures ? 1U : 0U) + (maps.wanted() ? 1U : 0U);
  }
  // `threads`: for one map; `processors`: all of them, for pictures when the gates have ended.
  // `normals`: the maps have those of the vertices.
  CheckExtras(std::shared_ptr<check::Meshes> meshes, bool pictures, DeviationMaps maps, bool normals, unsigned threads,
              unsigned processors);

  void ended(const check::GateOutcome& outcome);                                       // call it from Watch::ended
  void after(std::size_t place, const check::GateOutcome& outcome, Control& control);  // call it from Watch::after
  std::vector<check::GatePicture> pictures(const check::Report& report,
                                           const Interrupted& interrupted);  // empty: no pictures wanted

  const std::vector<std::string>& problems() const { return problems_; }  // complete when the run is over

 private:
  Error no_map(std::size_t place, const std::string& why) const;
  Result<Done> write_map(std::size_t place, const check::GateOutcome& outcome, Control& control);

  const std::shared_ptr<check::Meshes> meshes_;
  const DeviationMaps maps_;
  const bool normals_;
  const unsigned threads_;
  std::optional<check::Gallery> gallery_;
  std::mutex mutex_;  // guards the members below
  std::vector<std::string> problems_;
};

}  // namespace meshgauge::cli
