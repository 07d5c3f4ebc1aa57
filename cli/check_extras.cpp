#include "cli/check_extras.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <new>
#include <set>
#include <system_error>
#include <utility>

#include "api/base/refused.h"
#include "api/compare/compare.h"
#include "check/deviation.h"

namespace meshgauge::cli {
namespace {

// Makes a file's name of a gate's, without any path.
std::string file_name_of(std::string name) {
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_' && c != '.' && c < 0x80; }, '_');
  return name.front() == '.' ? "_" + name : name;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder,
                                            const std::vector<check::Gate>& gates) {
  std::set<std::string> taken;
  std::vector<std::filesystem::path> files;
  for (const check::Gate& gate : gates) {
    std::string name = file_name_of(gate.name);
    for (int i = 2; !taken.insert(name).second; ++i) name = file_name_of(gate.name) + "-" + std::to_string(i);
    files.push_back(folder / (name + ".ply"));
  }
  return files;
}

Error unusable(const std::string& where, const std::string& why) {
  return bad_flag("--deviation", "'" + where + "' " + why);
}

}  // namespace

Result<DeviationMaps> DeviationMaps::open(const std::string& where, bool of_manifest,
                                          const std::vector<check::Gate>& gates, Places& places) {
  DeviationMaps maps;
  if (where.empty()) return maps;
  if (!of_manifest) {
    if (auto ok = check::check_deviation_name(where); !ok) return ok.error();
    const auto folder = std::filesystem::path(where).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder))
      return unusable(where, "cannot be written: its folder does not exist");
    maps.files_ = {where};
    if (auto ok = places.writes("--deviation", where); !ok) return ok.error();
    return maps;
  }
  std::error_code failed;
  std::filesystem::create_directories(where, failed);
  if (!std::filesystem::is_directory(where))
    return unusable(where, "cannot be created as a folder: " + failed.message());
  maps.files_ = files_in(where, gates);
  for (const auto& file : maps.files_) {
    if (auto ok = places.writes("--deviation", file); !ok) return ok.error();
  }
  return maps;
}

CheckExtras::CheckExtras(std::shared_ptr<check::Meshes> meshes, bool pictures, DeviationMaps maps, bool normals,
                         unsigned threads, unsigned processors)
    : meshes_(std::move(meshes)), maps_(std::move(maps)), normals_(normals), threads_(threads) {
  if (pictures) gallery_.emplace(meshes_, processors);
}

void CheckExtras::ended(const check::GateOutcome& outcome) {
  if (gallery_) gallery_->add(outcome);
}

void CheckExtras::after(std::size_t place, const check::GateOutcome& outcome, Control& control) {
  if (gallery_) gallery_->wait_for_room(control);
  if (!maps_.wanted()) return;
  const check::Turn turn{*meshes_, outcome.gate};
  if (control.check() == Interruption::cancelled) return;
  const Result<Done> written = outcome.measured ? write_map(place, outcome, control) : Result<Done>(Done{});
  if (written || written.error().code == ErrorCode::out_of_time) return;
  const std::lock_guard lock(mutex_);
  problems_.push_back(written.error().message);
}

Result<Done> CheckExtras::write_map(std::size_t place, const check::GateOutcome& outcome, Control& control) try {
  const auto candidate = meshes_->get(outcome.gate.candidate, control);
  if (!candidate) return candidate.error();
  const auto baseline = meshes_->get(outcome.gate.baseline, control);
  if (!baseline) return baseline.error();
  const check::DeviationFile file{maps_.file_of(place), check::Refine::by_format, threads_, normals_};
  const auto pair =
      api::in_unit_of_result(*candidate, *baseline, outcome.measured->units, outcome.measured->motion, control);
  if (!pair) return pair.error();
  return check::write_deviation(file, *pair->a, *pair->b, *outcome.measured, control);
} catch (const std::bad_alloc&) {
  return no_map(place, "there is not enough memory");
} catch (const std::exception& error) {
  return no_map(place, error.what());
}

Error CheckExtras::no_map(std::size_t place, const std::string& why) const {
  return {ErrorCode::internal, "the deviation map '" + maps_.file_of(place).string() + "' could not be made: " + why,
          "", "--deviation"};
}

std::vector<check::GatePicture> CheckExtras::pictures(const check::Report& report, const Interrupted& interrupted) {
  return gallery_ ? gallery_->end(report, interrupted) : std::vector<check::GatePicture>{};
}

}  // namespace meshgauge::cli
