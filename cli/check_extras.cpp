#include "cli/check_extras.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <exception>
#include <fstream>
#include <iterator>
#include <new>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include "api/base/refused.h"
#include "api/compare/compare.h"
#include "check/deviation.h"
#include "check/files.h"
#include "check/html/image.h"
#include "check/picture_name.h"

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

Error unusable(const std::string& flag, const std::string& where, const std::string& why) {
  return bad_flag(flag, "'" + where + "' " + why);
}

Result<Done> make_folder(const std::string& flag, const std::string& where) {
  std::error_code failed, none;
  std::filesystem::create_directories(where, failed);
  if (std::filesystem::is_directory(where, none)) return Done{};
  return unusable(flag, where, "cannot be created as a folder: " + failed.message());
}

Result<Done> write_whole(const std::filesystem::path& place, std::span<const std::byte> bytes) {
  check::StagedFile staged(place);
  std::ofstream out(staged.path(), std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out && !staged.put()) return Done{};
  return Error{ErrorCode::internal, "the picture '" + place.string() + "' cannot be written", "", "--pictures"};
}

// What is there may go if an earlier run has made it. A folder stays, and the picture is not written.
Result<Done> may_be_replaced(const std::filesystem::path& file) {
  std::error_code none;
  const auto there = std::filesystem::symlink_status(file, none);
  if (!std::filesystem::exists(there) || std::filesystem::is_directory(there)) return Done{};
  std::array<std::byte, check::kMarkedBytes> beginning{};
  if (std::filesystem::is_regular_file(there))
    std::ifstream(file, std::ios::binary)
        .read(reinterpret_cast<char*>(beginning.data()), static_cast<std::streamsize>(beginning.size()));
  if (check::is_marked(beginning)) return Done{};
  return unusable("--pictures", file.string(),
                  "is no picture that meshgauge has made: move it away, or name another folder");
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
      return unusable("--deviation", where, "cannot be written: its folder does not exist");
    maps.files_ = {where};
    if (auto ok = places.writes("--deviation", where); !ok) return ok.error();
    return maps;
  }
  if (auto ok = make_folder("--deviation", where); !ok) return ok.error();
  maps.files_ = files_in(where, gates);
  for (const auto& file : maps.files_) {
    if (auto ok = places.writes("--deviation", file); !ok) return ok.error();
  }
  return maps;
}

Result<PictureFiles> PictureFiles::open(const std::string& where, const std::vector<check::Gate>& gates,
                                        Places& places) {
  PictureFiles pictures;
  if (where.empty()) return pictures;
  if (auto ok = make_folder("--pictures", where); !ok) return ok.error();
  for (const check::Gate& gate : gates) {
    pictures.files_.push_back(std::filesystem::path(where) / check::picture_name(gate.name));
    if (auto ok = places.writes("--pictures", pictures.files_.back()); !ok) return ok.error();
    if (auto ok = may_be_replaced(pictures.files_.back()); !ok) return ok.error();
  }
  for (const auto& file : pictures.files_) {
    std::error_code none;
    if (std::filesystem::is_regular_file(std::filesystem::symlink_status(file, none)))
      std::filesystem::remove(file, none);
  }
  return pictures;
}

CheckExtras::CheckExtras(std::shared_ptr<check::Meshes> meshes, std::size_t gates, Extras wanted, unsigned threads)
    : meshes_(std::move(meshes)), wanted_(std::move(wanted)), threads_(threads) {
  if (wanted_.any_pictures()) gallery_.emplace(meshes_, gates, wanted_.report_pictures);
}

void CheckExtras::after(std::size_t place, const check::GateOutcome& outcome, Control& control) {
  if (gallery_) draw(place, outcome, control);
  if (!wanted_.maps.wanted()) return;
  const check::Turn turn{*meshes_, outcome.gate};
  if (control.check() == Interruption::cancelled) return;
  const Result<Done> written = outcome.measured ? write_map(place, outcome, control) : Result<Done>(Done{});
  if (!written && written.error().code != ErrorCode::out_of_time) add_problem(written.error().message);
}

void CheckExtras::draw(std::size_t place, const check::GateOutcome& outcome, Control& control) {
  const bool strip = wanted_.pictures.wanted() && outcome.measured && outcome.verdict() != check::Verdict::pass &&
                     is_needed(check::Gallery::need_of(outcome));
  const check::Gallery::Strip made = gallery_->draw(outcome, strip, threads_, control);
  if (!made.missing.empty()) {
    const std::lock_guard lock(mutex_);
    notes_.push_back("the picture '" + wanted_.pictures.file_of(place).string() +
                     "' could not be made: " + made.missing);
  }
  if (made.png.empty()) return;
  if (const auto written = keep(place, check::Gallery::need_of(outcome), made.png); !written)
    add_problem(written.error().message);
}

bool CheckExtras::is_needed(const check::Gallery::Need& need) {
  const std::lock_guard lock(mutex_);
  return kept_.size() < check::Gallery::kMostPictures || need < kept_.rbegin()->first;
}

// Which pictures stay does not depend on the order in which gates end.
Result<Done> CheckExtras::keep(std::size_t place, const check::Gallery::Need& need, std::span<const std::byte> png) {
  const std::lock_guard lock(mutex_);
  kept_.emplace(need, place);
  if (kept_.size() > check::Gallery::kMostPictures) {
    const std::size_t least = kept_.rbegin()->second;
    kept_.erase(std::prev(kept_.end()));
    if (least == place) return Done{};
    std::error_code none;
    std::filesystem::remove(wanted_.pictures.file_of(least), none);
  }
  return write_whole(wanted_.pictures.file_of(place), png);
}

void CheckExtras::add_problem(const std::string& what) {
  const std::lock_guard lock(mutex_);
  problems_.push_back(what);
}

Result<Done> CheckExtras::write_map(std::size_t place, const check::GateOutcome& outcome, Control& control) try {
  const auto candidate = meshes_->get(outcome.gate.candidate, control);
  if (!candidate) return candidate.error();
  const auto baseline = meshes_->get(outcome.gate.baseline, control);
  if (!baseline) return baseline.error();
  const check::DeviationFile file{wanted_.maps.file_of(place), check::Refine::by_format, threads_, wanted_.map_normals};
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
  const std::string file = wanted_.maps.file_of(place).string();
  return {ErrorCode::internal, "the deviation map '" + file + "' could not be made: " + why, "", "--deviation"};
}

std::vector<check::GatePicture> CheckExtras::pictures(const check::Report& report, unsigned processors,
                                                      const Interrupted& interrupted,
                                                      const check::Gallery::Told& told) {
  return gallery_ ? gallery_->end(report, processors, interrupted, told) : std::vector<check::GatePicture>{};
}

}  // namespace meshgauge::cli
