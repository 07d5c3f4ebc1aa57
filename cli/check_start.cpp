#include "cli/check_start.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>

#include <CLI/CLI.hpp>

#include "api/base/refused.h"
#include "api/options/quantity.h"
#include "check/files.h"
#include "check/manifest/first_manifest.h"
#include "check/manifest/manifest.h"
#include "check/manifest/naming.h"
#include "check/reports/wording.h"
#include "check/run/terminal.h"
#include "cli/commands.h"

namespace meshgauge::cli {
namespace {

namespace fs = std::filesystem;

bool is_folder(const std::string& file) {
  std::error_code none;
  return fs::is_directory(file, none);
}

bool is_manifest(const std::string& file) {
  const std::string suffix = check::suffix_of(file);
  return suffix == ".yaml" || suffix == ".yml";
}

std::string without_slash(std::string folder) {
  while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  return folder;
}

// `folder`: of --init; empty: none is named.
std::vector<std::string> explanation(const std::string& what, const std::string& gate, const std::string& folder) {
  const std::string init = "meshgauge check --init" + (folder.empty() ? "" : " " + check::shown_path(folder));
  return {what + ". Several meshes stand in a manifest, gates.yaml:", "  version: 1", "  gates: [" + gate + "]",
          init + " writes one for the meshes that are there; meshgauge check gates.yaml runs it."};
}

// Prints one line, without anything that a terminal would interpret.
void say(std::FILE* out, const std::string& line) {
  std::fprintf(out, "%s\n", check::for_log(check::shown_name(line)).c_str());
}

int refuse_init(const std::string& why) {
  say(stderr, "meshgauge: --init: " + why);
  return kExitError;
}

// Does not follow a link and does not overwrite.
bool write_new(const fs::path& file, const std::string& text) {
  std::FILE* out = std::fopen(file.c_str(), "wx");
  if (!out) return false;
  const bool written = std::fputs(text.c_str(), out) >= 0;
  const bool closed = std::fclose(out) == 0;
  if (written && closed) return true;
  std::error_code none;
  fs::remove(file, none);
  return false;
}

}  // namespace

void take_manifest_here(CheckFlags& flags) {
  std::error_code none;
  if (flags.files.empty() && !flags.init && fs::exists(check::kManifestName, none))
    flags.files = {check::kManifestName};
}

std::vector<std::string> explain_manifest(const CheckFlags& flags) {
  const auto& files = flags.files;
  const std::string takes = "check takes two mesh files, CANDIDATE BASELINE, or one manifest of gates";
  if (files.empty())
    return explanation(takes + "; none is named, and there is no gates.yaml here", check::example_gate({}, "baselines"),
                       "");
  const bool folders = std::all_of(files.begin(), files.end(), is_folder);
  if (files.size() == 1 && folders) {
    const std::string folder = without_slash(files[0]), manifest = folder + "/" + check::kManifestName;
    std::error_code none;
    if (fs::exists(manifest, none)) return {};  // its message names the manifest
    return explanation(takes + ", not the folder " + check::shown_path(files[0]),
                       check::example_gate_of_folder(folder, "baselines"), folder);
  }
  if (files.size() == 2 && folders) {
    const std::string first = without_slash(files[0]), second = without_slash(files[1]);
    const std::string above =
        fs::path(first).parent_path() == fs::path(second).parent_path() ? fs::path(first).parent_path().string() : "";
    return explanation(takes + ", not two folders", check::example_gate_of_folder(first, second), above);
  }
  if (files.size() <= 2) return {};
  const auto json =
      std::find_if(files.begin(), files.end(), [](auto& file) { return check::suffix_of(file) == ".json"; });
  if (json != files.end() && flags.json == "-")
    return {bad_flag("--json", "needs '=' before its file: --json=" + *json).message};
  if (std::any_of(files.begin(), files.end(), is_manifest))
    return explanation(takes + ", alone; " + std::to_string(files.size()) + " files are named",
                       check::example_gate({}, "baselines"), "");
  std::vector<std::string> meshes;
  std::copy_if(files.begin(), files.end(), std::back_inserter(meshes),
               [](const auto& file) { return !is_folder(file); });
  const std::string folder = meshes.empty() ? "" : fs::path(meshes.front()).parent_path().string();
  return explanation(takes + "; " + std::to_string(files.size()) + " files are named",
                     check::example_gate(meshes, "baselines"), folder);
}

std::string unheard_by_init(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const bool heard = option->get_positional() || option->check_lname("init") || option->check_lname("max-distance");
    if (option->count() > 0 && !heard) return option->get_name();
  }
  return "";
}

int write_first_manifest(const CheckFlags& flags, const std::string& unheard) {
  if (!unheard.empty()) return refuse_init("writes a manifest and measures nothing: leave out " + unheard);
  if (flags.files.size() > 1)
    return refuse_init("takes one folder; " + std::to_string(flags.files.size()) + " are named");
  const std::string folder = flags.files.empty() ? "." : flags.files[0];
  if (!is_folder(folder))
    return refuse_init(check::shown_path(folder) + " is no folder: name the one that holds the meshes");
  const std::string limit = flags.options.has("--max-distance") ? flags.options.text("--max-distance") : "0.1 %";
  if (const auto ok = api::parse_length(limit, true); !ok) return refuse_init("--max-distance: " + ok.error().message);
  const fs::path file = flags.files.empty() ? fs::path(check::kManifestName) : fs::path(folder) / check::kManifestName;
  std::error_code none;
  if (fs::exists(fs::symlink_status(file, none)))
    return refuse_init(check::shown_path(file) + " exists and is left as it is: run it, or remove it first");
  const auto manifest = check::first_manifest(folder, limit);
  if (!manifest) return refuse_init(manifest.error().message);
  if (!write_new(file, manifest->text)) return refuse_init(check::shown_path(file) + " could not be written");
  say(stdout, "wrote " + file.string());
  std::fputs(manifest->text.c_str(), stdout);
  for (const std::string& what : manifest->left_out) say(stderr, "meshgauge: " + what);
  const auto run = check::gates_of(file);
  for (const check::Mistake& mistake : check::defects_of(run))
    say(stderr, "to do: " + check::to_string(file.string(), mistake));
  say(stdout, "Look at max_distance in it, then run: meshgauge check " + check::shown_path(file));
  return std::fflush(stdout) == 0 ? kExitResult : kExitError;
}

}  // namespace meshgauge::cli
