#include "cli/check_flags.h"

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/formats/detect.h"
#include "check/files.h"
#include "check/manifest/manifest.h"
#include "check/manifest/naming.h"
#include "check/run/terminal.h"
#include "cli/check_start.h"
#include "cli/pipes.h"

namespace meshgauge::cli {
namespace {

// Those that may differ between machines: for two files and for the gates of a manifest alike.
constexpr std::string_view kCommon[] = {"--timeout", "--threads", "--statistics", "--samples", "--seed", "--fast"};

bool is_common(const std::string& flag) { return std::ranges::find(kCommon, flag) != std::end(kCommon); }

Result<Done> set_common(const CheckFlags& flags, check::Gate& gate) {
  const auto common = flags.options.request();
  if (!common) return common.error();
  if (flags.options.has("--timeout")) gate.request.timeout = common->timeout;
  if (flags.options.has("--threads")) {
    gate.request.options.threads = common->options.threads;
    gate.request.threads_given = common->threads_given;
  }
  if (const auto& asked = common->options.statistics) {
    auto& statistics = gate.request.options.statistics;
    if (!statistics) statistics.emplace();
    if (flags.options.has("--samples")) statistics->samples = asked->samples;
    if (flags.options.has("--seed")) statistics->seed = asked->seed;
  }
  if (flags.options.has("--fast")) gate.request.options.narrow = false;
  return Done{};
}

Result<check::Gate> gate_of_pair(const CheckFlags& flags) {
  check::Gate gate;
  gate.name = name_of_mesh(flags.files[0]);
  gate.candidate = flags.files[0];
  gate.baseline = flags.files[1];
  if (auto ok = check_pipes(flags.files[0], flags.files[1]); !ok) return ok.error();
  if (!flags.is_against && check::is_same_file(gate.candidate, gate.baseline))
    return bad_flag("FILES", "candidate and baseline are the same file, '" + flags.files[0] + "': name two files");
  auto request = flags.options.request();
  if (!request) return request.error();
  if (!has_limit(request->options) && flags.update.empty()) {
    const std::vector<std::string> limits = OptionFlags::limits();
    return bad_flag(limits[0], "is needed for two files, as in --max-distance '0.05 mm'; or " +
                                   api::listed(std::span(limits).subspan(1), " or "));
  }
  gate.request = *std::move(request);
  gate.cloud = flags.cloud;
  return gate;
}

// Refuses flags that stand in the manifest of gates, where each has a line.
Result<Done> fit_manifest(const CheckFlags& flags) {
  std::vector<std::string> given = flags.options.given();
  if (flags.cloud) given.emplace_back("--cloud");
  for (const std::string& name : given) {
    if (!is_common(name))
      return bad_flag(name, "is for two mesh files: write it into the manifest '" + flags.files[0] + "'");
  }
  return Done{};
}

bool is_one_of(const std::string& file, std::initializer_list<std::string_view> suffixes) {
  return std::find(suffixes.begin(), suffixes.end(), check::suffix_of(file)) != suffixes.end();
}

// By its name.
bool is_mesh(const std::string& file) {
  return !is_one_of(file, {".yaml", ".yml"}) && (api::format_by_name(file) || is_one_of(file, {".zip"}));
}

// Refuses files whose names contradict their roles.
Result<Done> fit_files(const CheckFlags& flags) {
  const std::string& first = flags.files[0];
  const bool manifest = is_one_of(first, {".yaml", ".yml"});
  if (flags.files.size() == 1) {
    if (!is_mesh(first)) return Done{};
    return bad_flag("FILES", api::shown_text(first) + " is a mesh: name its baseline behind it, and --max-distance");
  }
  const std::string& second = flags.files[1];
  if (manifest && is_one_of(second, {".json"})) {
    return bad_flag("--json", "needs '=' before its file: --json=" + second);
  }
  if (manifest || is_one_of(second, {".yaml", ".yml"})) {
    return bad_flag("FILES",
                    api::shown_text(manifest ? first : second) + " is a manifest: give it alone, without other files");
  }
  if (is_one_of(second, {".json"})) return bad_flag("--json", "needs '=' before its file: --json=" + second);
  return Done{};
}

Asked mistaken(const Error& error) {
  Asked asked{{}, {{0, 0, error.message}}, ""};
  for (const Error& other : error.others) asked.mistakes.push_back({0, 0, other.message});
  return asked;
}

Asked gates_of_manifest(const CheckFlags& flags) {
  if (const auto ok = fit_manifest(flags); !ok) return mistaken(ok.error());
  const auto baselines = !flags.update.empty() ? check::Baselines::may_be_missing
                         : flags.is_against    ? check::Baselines::of_revision
                                               : check::Baselines::must_exist;
  check::Gates read = check::gates_of(flags.files[0], baselines, check::Selection(flags.only));
  return {std::move(read.gates), std::move(read.mistakes), flags.files[0], {}, std::move(read.open)};
}

Asked all_gates(const CheckFlags& flags) {
  if (flags.files.size() == 1) return gates_of_manifest(flags);
  auto gate = gate_of_pair(flags);
  if (!gate) return mistaken(gate.error());
  return {{std::move(*gate)}, {}, ""};
}

// Each pattern must match a gate; otherwise a misspelt one would silently leave its gates out.
void keep_only(const std::vector<std::string>& patterns, Asked& asked) {
  for (const std::string& pattern : patterns) {
    const auto named = [one = check::Selection({pattern})](const check::Gate& gate) { return one.holds(gate.name); };
    if (std::any_of(asked.gates.begin(), asked.gates.end(), named)) continue;
    asked.mistakes.push_back({0, 0, "--only: no gate has a name that matches " + api::shown_text(pattern)});
  }
  const check::Selection only(patterns);
  std::erase_if(asked.gates, [&](const check::Gate& gate) { return !only.holds(gate.name); });
}

// An empty pattern is refused: an empty variable of a pipeline does not mean all gates.
Result<Done> fit_only(const CheckFlags& flags) {
  const auto is_empty = [](const std::string& pattern) { return pattern.empty(); };
  if (std::none_of(flags.only.begin(), flags.only.end(), is_empty)) return Done{};
  return bad_flag("--only", "is empty: name gates, or leave it out for all of them");
}

void declare_measuring(CLI::App& command, CheckFlags& flags) {
  flags.options.declare(command, OptionFlags::Command::check);
  command.add_flag("--cloud", flags.cloud, "CANDIDATE may be a point cloud; an XYZ always may");
  command.add_option("--jobs", flags.jobs, "Gates at the same time; 0: one for each processor")->capture_default_str();
  command
      .add_option("--only", flags.only,
                  "Only the gates whose name matches this pattern of *, ? and [..], or one of several --only")
      ->allow_extra_args(false);
  command.add_option("--undecided", flags.undecided, "Count what is undecided as fail (exit 1) or only warn (exit 0)")
      ->check(CLI::IsMember({"fail", "warn"}));
}

void declare_reports(CLI::App& command, CheckFlags& flags) {
  command.add_flag("--json{-}", flags.json, "Write the report as JSON to standard output, or to --json=FILE");
  command.add_option("--junit", flags.junit,
                     "Write the report as JUnit XML; '-' is standard output, as for all reports");
  command.add_option("--sarif", flags.sarif, "Write the report as SARIF 2.1.0");
  command.add_option("--markdown", flags.markdown, "Write the report as Markdown, for a job summary");
  command.add_option("--comment", flags.comment,
                     "Write the report as Markdown for a comment on a pull request, at most 60 kB");
  command.add_option("--since", flags.since,
                     "Say in --markdown and --comment what changed since this report of --json, of an earlier run");
  command.add_flag("--annotations{-}", flags.annotations,
                   "Write GitHub's annotations to standard error, or to --annotations=FILE; on by default where the "
                   "variable GITHUB_ACTIONS is 'true'");
  command.add_flag("--no-annotations", flags.no_annotations, "Write no annotations")->excludes("--annotations");
  command.add_option("--code-quality", flags.code_quality, "Write the report as GitLab's Code Quality JSON");
  command.add_option("--html", flags.html, "Write the report as one HTML file, with pictures of the meshes");
  command.add_option("--pictures", flags.pictures,
                     "Write a PNG of each gate that does not pass into this folder: before, after and the difference");
  command.add_option(
      "--deviation,--map", flags.deviation,
      "Write the candidate coloured by its distance, signed where the gate limits sides: FILE.ply, .glb, .vtp or "
      ".csv; for a manifest a folder");
  command.add_flag("--map-normals", flags.map_normals, "Also write the normal of each vertex to the deviation map")
      ->needs("--deviation");
  command.add_option(
      "--history", flags.history,
      "Append the result of each gate to this file of JSON lines, and show the last runs in the reports");
  command.add_flag("--quiet", flags.quiet, "Print nothing about gates that pass, and no progress");
  command.add_flag("--no-colour,--no-color", flags.no_colour, "No colours, as with the variable NO_COLOR");
}

void declare_service(CLI::App& command, CheckFlags& flags) {
  command.add_option("--server", flags.server, "Have a meshgauge service measure: its http or https address");
  command.add_option("--key-file", flags.key_file, "File with the service's key; else the variable MESHGAUGE_KEY")
      ->needs("--server");
  command
      .add_flag("--key-in-clear", flags.key_in_clear,
                "Allow sending the key by http://, where it can be read in transit")
      ->needs("--server");
  command.add_option("--ca-file", flags.ca_file, "PEM file of the certificates to trust, instead of this machine's")
      ->needs("--server");
}

}  // namespace

void declare(CLI::App& command, CheckFlags& flags) {
  command
      .add_option(
          "FILES", flags.files,
          "CANDIDATE BASELINE: two mesh files, with --max-distance; or one manifest of gates (YAML); none: gates.yaml")
      ->expected(0, -1);  // more than two are explained
  declare_measuring(command, flags);
  declare_reports(command, flags);
  declare_service(command, flags);
  CLI::Option* update =
      command
          .add_flag(
              "--update-baselines{differing}", flags.update,
              "Measure, then copy the candidate of each gate that does not pass over its baseline; =all: of every "
              "gate, without measuring; =missing: only where there is no baseline")
          ->check(CLI::IsMember({kUpdateDiffering, kUpdateAll, kUpdateMissing}));
  for (const char* unheard : {"--json", "--junit", "--sarif", "--markdown", "--comment", "--since", "--annotations",
                              "--code-quality", "--html", "--pictures", "--deviation", "--history", "--server",
                              "--statistics", "--samples", "--seed", "--fast", "--undecided"}) {
    update->excludes(command.get_option(unheard));  // these flags are about a report
  }
  command.add_flag("--dry-run", flags.dry_run, "With --update-baselines: only say what it would do")->needs(update);
  command
      .add_option_function<std::string>(
          "--against", [&flags](const std::string& ref) { flags.against = ref, flags.is_against = true; },
          "Read the baselines from this git revision, as main or HEAD~1; one mesh alone is compared with its own")
      ->excludes(update);
  command.add_flag("--init", flags.init,
                   "Measure nothing: write a gates.yaml for the meshes of FILES, a folder; none: this one");
}

void take_own_baseline(CheckFlags& flags) {
  if (flags.is_against && flags.files.size() == 1 && is_mesh(flags.files[0])) flags.files.push_back(flags.files[0]);
}

Asked gates_asked(const CheckFlags& flags) {
  if (auto lines = explain_manifest(flags); !lines.empty())
    return {{}, {{0, 0, lines.front()}}, "", {std::next(lines.begin()), lines.end()}};
  if (const auto ok = fit_files(flags); !ok) return mistaken(ok.error());
  if (const auto ok = fit_only(flags); !ok) return mistaken(ok.error());
  Asked asked = all_gates(flags);
  if (!asked.mistakes.empty()) return asked;
  for (check::Gate& gate : asked.gates) {
    if (const auto ok = set_common(flags, gate); !ok) return mistaken(ok.error());
  }
  asked.manifest.clear();
  keep_only(flags.only, asked);
  if (asked.gates.empty() && asked.mistakes.empty())
    asked.mistakes.push_back({0, 0, "the manifest has no gate to check"});
  return asked;
}

std::string place_of_annotations(const CheckFlags& flags) {
  if (flags.no_annotations || !flags.annotations.empty()) return flags.no_annotations ? "" : flags.annotations;
  return check::is_on_github() ? "-" : "";
}

check::Undecided undecided_rule(const CheckFlags& flags) {
  if (flags.undecided.empty()) return check::Undecided::separate;
  return flags.undecided == "fail" ? check::Undecided::fail : check::Undecided::warn;
}

}  // namespace meshgauge::cli
