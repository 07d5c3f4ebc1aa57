#include "cli/check_flags.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>

#include "api/formats/detect.h"
#include "api/json_filter.h"
#include "api/names.h"
#include "api/refused.h"
#include "api/request.h"
#include "check/files.h"
#include "check/manifest/expect_setting.h"
#include "check/manifest/manifest.h"
#include "check/manifest/names.h"
#include "check/manifest/naming.h"
#include "check/manifest/quantities.h"
#include "check/manifest/region_setting.h"
#include "check/selection.h"
#include "cli/check_start.h"
#include "cli/pipes.h"
#include "cli/read_flag.h"

namespace meshgauge::cli {
namespace {

Result<Done> set_timeout(const CheckFlags& flags, check::Gate& gate) {
  return read_flag("--timeout", flags.timeout, check::parse_duration, gate.timeout);
}

Result<Done> set_threads(const CheckFlags& flags, check::Gate& gate) {
  if (!flags.threads) return Done{};
  const auto threads = api::in_range(*flags.threads, api::kThreadsRange, "--threads");
  if (!threads) return threads.error();
  gate.options.threads = static_cast<unsigned>(*threads);
  gate.threads_given = true;
  return Done{};
}

// Applies flags that may differ between machines, to two files and to the gates of a manifest alike.
Result<Done> set_common(const CheckFlags& flags, check::Gate& gate) {
  if (auto ok = set_timeout(flags, gate); !ok) return ok;
  if (auto ok = set_threads(flags, gate); !ok) return ok;
  gate.statistics = gate.statistics || flags.statistics;
  gate.options.narrow = !flags.fast;
  return Done{};
}

Result<Done> set_names(const CheckFlags& flags, Options& options) {
  if (flags.direction) {
    const auto direction = api::value_of(api::kDirectionWords, *flags.direction);
    if (!direction)
      return bad_flag("--direction", "must be one of " + api::list_of(api::kDirectionWords) + ", not " +
                                         api::shown_text(*flags.direction));
    options.direction = *direction;
  }
  if (flags.strategy) {
    const auto strategy = api::value_of(api::kStrategies, *flags.strategy);
    if (!strategy)
      return bad_flag("--strategy",
                      "must be one of " + api::list_of(api::kStrategies) + ", not " + api::shown_text(*flags.strategy));
    options.strategy = *strategy;
  }
  return Done{};
}

Result<Done> set_limits(const CheckFlags& flags, check::Gate& gate) {
  if (!flags.max_distance && !flags.max_share_beyond && !flags.zone)
    return bad_flag("--max-distance",
                    "is needed for two files, as in --max-distance '0.05 mm'; or --max-share-beyond or --zone");
  if (auto ok = read_flag("--max-distance", flags.max_distance, check::parse_limit, gate.limit); !ok) return ok;
  if (auto ok = read_flag("--max-share-beyond", flags.max_share_beyond, check::parse_area_limit, gate.area_limit); !ok)
    return ok;
  if (auto ok = read_flag("--zone", flags.zone, check::parse_zone, gate.zone); !ok) return ok;
  if (auto ok = read_flag("--uncertainty", flags.uncertainty, check::parse_limit, gate.uncertainty); !ok) return ok;
  if (auto ok = read_flag("--regions", flags.regions, check::parse_regions, gate.regions); !ok) return ok;
  const auto ok = check::check_limits(gate);
  return ok ? ok : bad_flag(flag_beside(flags.uncertainty, flags.zone), ok.error().message);
}

Result<check::Gate> gate_of_pair(const CheckFlags& flags) {
  check::Gate gate;
  gate.name = name_of_mesh(flags.files[0]);
  gate.candidate = flags.files[0];
  gate.baseline = flags.files[1];
  if (auto ok = check_pipes(flags.files[0], flags.files[1]); !ok) return ok.error();
  if (check::is_same_file(gate.candidate, gate.baseline))
    return bad_flag("FILES", "candidate and baseline are the same file, '" + flags.files[0] + "': name two files");
  if (flags.update_baselines) return gate;  // a limit is not needed
  if (auto ok = set_names(flags, gate.options); !ok) return ok.error();
  if (auto ok = set_limits(flags, gate); !ok) return ok.error();
  if (auto ok = set_units(flags.units, gate.options.units); !ok) return ok.error();
  if (auto ok = set_align(flags.align, gate.options.align); !ok) return ok.error();
  if (auto ok = read_flag("--expect", flags.expect, check::parse_expect, gate.expect); !ok) return ok.error();
  gate.cloud = flags.cloud;
  return gate;
}

// Refuses flags that stand in the manifest of gates, where each has a line.
Result<Done> fit_manifest(const CheckFlags& flags) {
  const std::pair<const char*, bool> given[] = {{"--max-distance", flags.max_distance.has_value()},
                                                {"--max-share-beyond", flags.max_share_beyond.has_value()},
                                                {"--zone", flags.zone.has_value()},
                                                {"--uncertainty", flags.uncertainty.has_value()},
                                                {"--regions", flags.regions.has_value()},
                                                {"--expect", flags.expect.has_value()},
                                                {"--unit", flags.units.both.has_value()},
                                                {"--unit-a", flags.units.a.has_value()},
                                                {"--unit-b", flags.units.b.has_value()},
                                                {"--direction", flags.direction.has_value()},
                                                {"--cloud", flags.cloud},
                                                {"--align", flags.align.has_value()},
                                                {"--strategy", flags.strategy.has_value()}};
  for (const auto& [name, is_given] : given) {
    if (is_given) return bad_flag(name, "is for two mesh files: write it into the manifest '" + flags.files[0] + "'");
  }
  return Done{};
}

// Refuses files whose names contradict their roles.
Result<Done> fit_files(const CheckFlags& flags) {
  const auto is_one_of = [](const std::string& file, std::initializer_list<std::string_view> suffixes) {
    return std::find(suffixes.begin(), suffixes.end(), check::suffix_of(file)) != suffixes.end();
  };
  const std::string& first = flags.files[0];
  const bool manifest = is_one_of(first, {".yaml", ".yml"});
  if (flags.files.size() == 1) {
    const bool mesh = !manifest && (api::format_by_name(first) || is_one_of(first, {".zip"}));
    return mesh ? bad_flag("FILES",
                           api::shown_text(first) + " is a mesh: name its baseline behind it, and --max-distance")
                : Result<Done>(Done{});
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

Asked mistaken(const Error& error) { return {{}, {{0, 0, error.message}}, ""}; }

Asked gates_of_manifest(const CheckFlags& flags) {
  if (const auto ok = fit_manifest(flags); !ok) return mistaken(ok.error());
  const auto baselines = flags.update_baselines ? check::Baselines::may_be_missing : check::Baselines::must_exist;
  check::Gates read = check::gates_of(flags.files[0], baselines, check::Selection(flags.only));
  return {std::move(read.gates), std::move(read.mistakes), flags.files[0]};
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
  command.add_option("--max-distance", flags.max_distance,
                     "The largest distance that passes: '0.05', '0.05 mm', or '0.5 %' of the baseline's diagonal");
  command.add_option("--max-share-beyond", flags.max_share_beyond,
                     "The largest share of the area that may be farther than a distance: '0.05 mm: 1 %'");
  command.add_option("--zone", flags.zone,
                     "How far CANDIDATE may be inside and outside of BASELINE, a closed mesh: '-0.05 mm, 0.1 mm'");
  command.add_option("--uncertainty", flags.uncertainty,
                     "Of the distances: pass and fail only by more than this; '0.01 mm' (ISO 14253-1)");
  command.add_option("--regions", flags.regions, kRegionsHelp);
  command.add_option("--expect", flags.expect, kExpectHelp);
  declare(command, flags.units, "CANDIDATE", "BASELINE");
  command.add_option("--direction", flags.direction, "symmetric, candidate_to_baseline, baseline_to_candidate");
  command.add_flag("--cloud", flags.cloud, "CANDIDATE may be a point cloud; an XYZ always may");
  command.add_option("--align", flags.align, kAlignHelp);
  command.add_option("--timeout", flags.timeout, "Of each gate: '60 s', '500 ms', or a number of seconds");
  command.add_option("--strategy", flags.strategy, api::list_of(api::kStrategies));
  command.add_option("--threads", flags.threads, "Of each gate; without it the gates share the processors");
  command.add_flag("--statistics", flags.statistics, "Sample mean, RMS, percentiles and a histogram as well");
  command.add_flag("--fast", flags.fast, "End each gate as soon as it is decided, without narrowing its interval");
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
  command.add_option("--code-quality", flags.code_quality, "Write the report as GitLab's Code Quality JSON");
  command.add_option("--html", flags.html, "Write the report as one HTML file, with pictures of the meshes");
  command.add_option("--deviation,--map", flags.deviation,
                     "Write the candidate coloured by its distance, signed where the gate has a zone: FILE.ply, .glb, "
                     ".vtp or .csv; for a manifest a folder");
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
  CLI::Option* update = command.add_flag("--update-baselines", flags.update_baselines,
                                         "Measure nothing: copy each gate's candidate over its baseline");
  for (const char* unheard : {"--json", "--junit", "--sarif", "--markdown", "--code-quality", "--html", "--deviation",
                              "--history", "--server", "--statistics", "--fast", "--undecided"}) {
    update->excludes(command.get_option(unheard));  // these flags are about a measurement
  }
  command.add_flag("--dry-run", flags.dry_run, "With --update-baselines: only say what it would do")->needs(update);
  command.add_flag("--init", flags.init,
                   "Measure nothing: write a gates.yaml for the meshes of FILES, a folder; none: this one");
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

check::Undecided undecided_rule(const CheckFlags& flags) {
  if (flags.undecided.empty()) return check::Undecided::separate;
  return flags.undecided == "fail" ? check::Undecided::fail : check::Undecided::warn;
}

}  // namespace meshgauge::cli
