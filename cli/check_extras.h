// Makes pictures and deviation maps of the meshes of a run.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
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

// Files of --pictures: one in a folder for each gate, by its name (check/picture_name.h).
class PictureFiles {
 public:
  // As DeviationMaps::open(). Also removes the pictures of these gates that an earlier run has left there, so that none
  // is taken for one of this run; any other file in their place is an Error.
  static Result<PictureFiles> open(const std::string& where, const std::vector<check::Gate>& gates, Places& places);

  bool wanted() const { return !files_.empty(); }
  const std::filesystem::path& file_of(std::size_t gate) const { return files_.at(gate); }

 private:
  std::vector<std::filesystem::path> files_;  // one per gate
};

// What is wanted beside the measurement.
struct Extras {
  bool report_pictures = false;  // those of the HTML report
  PictureFiles pictures;
  DeviationMaps maps;
  bool map_normals = false;

  bool any_pictures() const { return report_pictures || pictures.wanted(); }
  // Number of turns that the meshes must have for it, beside those of others.
  unsigned turns() const { return (any_pictures() ? 1U : 0U) + (maps.wanted() ? 1U : 0U); }
};

// after() is thread safe; the others are for the thread that runs the gates.
class CheckExtras {
 public:
  // `gates`: of the whole run. `threads`: for the pictures and the map of one gate.
  CheckExtras(std::shared_ptr<check::Meshes> meshes, std::size_t gates, Extras wanted, unsigned threads);

  void after(std::size_t place, const check::GateOutcome& outcome, Control& control);  // call it from Watch::after
  // The pictures of the HTML report, on all `processors`; empty: none are wanted. `told`: as Gallery::end().
  std::vector<check::GatePicture> pictures(const check::Report& report, unsigned processors,
                                           const Interrupted& interrupted, const check::Gallery::Told& told);

  // Both are complete when the run is over. Notes change no exit code.
  const std::vector<std::string>& problems() const { return problems_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  void draw(std::size_t place, const check::GateOutcome& outcome, Control& control);
  bool is_needed(const check::Gallery::Need& need);
  Result<Done> keep(std::size_t place, const check::Gallery::Need& need, std::span<const std::byte> png);
  Error no_map(std::size_t place, const std::string& why) const;
  Result<Done> write_map(std::size_t place, const check::GateOutcome& outcome, Control& control);
  void add_problem(const std::string& what);

  const std::shared_ptr<check::Meshes> meshes_;
  const Extras wanted_;
  const unsigned threads_;
  std::optional<check::Gallery> gallery_;
  std::mutex mutex_;  // guards the members below
  std::vector<std::string> problems_, notes_;
  std::map<check::Gallery::Need, std::size_t> kept_;  // files of --pictures: Gallery::kMostPictures at most
};

}  // namespace meshgauge::cli
