#include "check/manifest/baselines.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "api/base/json_filter.h"
#include "api/base/whole_file.h"
#include "api/compare/load.h"
#include "api/formats/gltf/gltf_bundle.h"
#include "check/files.h"
#include "check/manifest/naming.h"
#include "engine/control.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

bool has_same_bytes(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  if (fs::file_size(a, failed) != fs::file_size(b, failed) || failed) return false;
  std::ifstream in_a(a, std::ios::binary), in_b(b, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return in_a && in_b && std::equal(Bytes(in_a), Bytes(), Bytes(in_b), Bytes());
}

// Returns why the candidate cannot be the gate's baseline: it is no mesh, or lacks a group of the gate. Every later
// check would be an error.
std::optional<std::string> mesh_defect(const Gate& gate) {
  const fs::path& file = gate.candidate;
  const auto whole = api::WholeFile::open(file.string());
  if (!whole) return "cannot be read";
  const api::MeshInput input{file.string(), whole->bytes(), file.string(), ""};
  const auto mesh = api::load(input, api::ReadLimits{});
  if (!mesh) return "cannot be read: " + mesh.error().message;
  for (const Region& region : gate.request.options.regions) {
    const auto* const group = std::get_if<Group>(&region.shape);
    if (group && !api::find_group(mesh->groups, group->name))
      return "has no group " + api::shown_text(group->name) + ", which the region " + api::shown_text(region.name) +
             " needs: export it with its groups, or change the region";
  }
  return std::nullopt;
}

bool has_group(const Gate& gate) { return std::ranges::any_of(gate.request.options.regions, &Region::is_group); }

// Returns why the candidate is more than one file: a copy of the .gltf alone would lack the files beside it.
std::optional<std::string> several_files_defect(const fs::path& candidate) {
  const auto whole = api::WholeFile::open(candidate.string());
  if (!whole || !api::is_gltf_json(whole->bytes())) return std::nullopt;  // reported elsewhere
  const auto names = api::files_named_by(whole->bytes());
  if (names.empty()) return std::nullopt;
  return "names " + shown_path(names.front()) + " beside it, which would not be copied: export it as one .glb";
}

// Returns the first folder on the way to `file` that is a symbolic link out of `root`. Preconditions: both are
// without links.
std::optional<fs::path> way_out(const fs::path& start, const fs::path& way, const fs::path& root) {
  fs::path place = start;
  for (const fs::path& part : way.parent_path()) {
    place /= part;
    std::error_code failed;
    if (!fs::is_symlink(fs::symlink_status(place, failed))) continue;
    const fs::path target = fs::weakly_canonical(place, failed);
    if (failed || !is_below(target, root)) return place;
    place = target;
  }
  return std::nullopt;
}

std::optional<fs::path> way_out(const fs::path& baseline, const std::string& manifest) {
  std::error_code failed;
  const fs::path here = fs::current_path(failed);
  const fs::path folder = (here / fs::path(manifest).parent_path()).lexically_normal();
  const fs::path target = (here / baseline).lexically_normal();
  const fs::path root = fs::weakly_canonical(folder, failed);
  return is_below(target, folder) ? way_out(root, target.lexically_relative(folder), root)
                                  : way_out("/", target.relative_path(), root);
}

class Planner {
 public:
  void add(const Gate& gate) {
    for (const Mistake& defect : gate.defects)
      mistakes.add({defect.line, defect.column}, "gate " + api::shown_text(gate.name) + ": " + defect.message);
    if (!gate.defects.empty()) return;
    if (const auto wrong = file_defect(gate.candidate)) return refuse(gate, "candidate", gate.candidate, *wrong);
    if (const auto wrong = several_files_defect(gate.candidate)) {
      return refuse(gate, "candidate", gate.candidate, *wrong);
    }
    if (const auto wrong = baseline_defect(gate)) return refuse(gate, "baseline", gate.baseline, *wrong);
    const auto [first, is_new] = candidates_.emplace(gate.baseline, gate.candidate);
    if (!is_new && !is_same_file(first->second, gate.candidate))
      return refuse(gate, "baseline", gate.baseline,
                    "is that of " + shown_path(first->second) + " as well: leave one of the two gates out");
    if (is_new || has_group(gate)) add_update(gate, is_new);
  }

  std::vector<Update> updates;
  Mistakes mistakes;

 private:
  void refuse(const Gate& gate, const char* which, const fs::path& file, const std::string& wrong) {
    mistakes.add({gate.line, gate.line > 0 ? 1 : 0},
                 "gate " + api::shown_text(gate.name) + ": the " + which + " " + shown_path(file) + " " + wrong);
  }

  static std::optional<std::string> baseline_defect(const Gate& gate) {
    std::error_code failed;
    const fs::file_status status = fs::symlink_status(gate.baseline, failed);
    if (fs::is_symlink(status)) {
      return "is a symbolic link to " + shown_path(fs::read_symlink(gate.baseline, failed)) +
             ": name the file itself, or remove the link";
    }
    if (fs::exists(status) && !fs::is_regular_file(status)) return "is not a regular file";
    if (const auto link = way_out(gate.baseline, gate.manifest)) {
      return "lies behind the symbolic link " + shown_path(*link) + ", which leads out of the folder of the manifest";
    }
    if (is_same_file(gate.candidate, gate.baseline)) return "is the candidate itself";
    if (suffix_of(gate.candidate) == suffix_of(gate.baseline)) return std::nullopt;
    return "would hold what " + shown_path(gate.candidate) + " holds, and ends in another suffix: name it alike";
  }

  void add_update(const Gate& gate, bool is_new) {
    Update update{gate.name, gate.candidate, gate.baseline, Update::Kind::create};
    std::error_code failed;
    if (fs::exists(gate.baseline, failed)) {
      const bool same = has_same_bytes(gate.candidate, gate.baseline);
      update.kind = same ? Update::Kind::none : Update::Kind::replace;
    }
    const auto wrong = update.kind == Update::Kind::none ? std::nullopt : mesh_defect(gate);
    if (wrong) return refuse(gate, "candidate", gate.candidate, *wrong);
    if (is_new) updates.push_back(std::move(update));
  }

  std::map<fs::path, fs::path> candidates_;  // baseline -> candidate
};

Error failed_to(const std::string& what, const fs::path& file, const std::error_code& why) {
  return Error{ErrorCode::internal, shown_path(file) + " could not be " + what + ": " + why.message(), "", ""};
}

Result<StagedFile> staged_copy(const Update& update) {
  std::error_code failed;
  fs::create_directories(update.baseline.parent_path() / ".", failed);
  if (failed) return failed_to("made", update.baseline.parent_path(), failed);
  StagedFile copy(update.baseline);
  fs::copy_file(update.candidate, copy.path(), failed);
  if (!failed && update.kind == Update::Kind::replace) {  // keep the permissions of the old file
    fs::permissions(copy.path(), fs::status(update.baseline, failed).permissions(), failed);
  }
  if (failed) return failed_to("written", update.baseline, failed);
  return copy;
}

}  // namespace

Updates plan_updates(const std::vector<Gate>& gates) {
  Planner planner;
  for (const Gate& gate : gates) planner.add(gate);
  return {std::move(planner.updates), std::move(planner.mistakes).sorted()};
}

Result<Done> carry_out(const Updates& updates) {
  std::vector<StagedFile> all;
  for (const Update& update : updates.updates) {
    if (update.kind == Update::Kind::none) continue;
    auto staged = staged_copy(update);
    if (!staged) return staged.error();
    all.push_back(std::move(staged).value());
  }
  for (StagedFile& staged : all) {
    if (const auto failed = staged.put()) return failed_to("written", staged.place(), failed);
  }
  return Done{};
}

std::string to_string(const Update& update) {
  const std::string from = update.baseline.string() + " from " + update.candidate.string();
  if (update.kind == Update::Kind::create) return "create " + from;
  if (update.kind == Update::Kind::replace) return "replace " + from;
  return "leave " + update.baseline.string() + ", the same as " + update.candidate.string();
}

}  // namespace meshgauge::check
