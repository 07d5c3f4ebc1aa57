#include "api/compare.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "api/criteria.h"
#include "api/gate.h"
#include "api/measured_pair.h"
#include "api/mesh_file.h"
#include "api/names.h"
#include "api/processors.h"
#include "api/refused.h"
#include "api/region_json.h"
#include "api/request.h"
#include "api/response.h"
#include "api/result_document.h"
#include "check/deviation.h"
#include "check/manifest/expect_setting.h"
#include "check/manifest/quantities.h"
#include "check/manifest/region_setting.h"
#include "check/text.h"
#include "cli/check_extras.h"
#include "cli/commands.h"
#include "cli/heap.h"
#include "cli/interrupts.h"
#include "cli/pipes.h"
#include "cli/places.h"
#include "cli/read_flag.h"
#include "cli/report.h"
#include "cli/unit_flags.h"

namespace meshgauge::cli {
namespace {

struct Flags {
  std::string a;
  std::string b;
  std::string direction{api::name_of(api::kDirections, Options{}.direction)};
  std::string strategy{api::name_of(api::kStrategies, Options{}.strategy)};
  std::optional<double> absolute, diagonal, relative, points, work_items, memory_bytes, samples, seed;
  std::optional<std::string> max_distance, max_share_beyond, zone, uncertainty, regions, align, expect;
  std::vector<double> beyond, quantiles;
  std::optional<double> share_tolerance, length_tolerance;
  bool mean = false;
  bool sides = false;
  UnitFlags units;
  double timeout_ms = 30'000;
  double threads = 0;
  std::string simd = "auto";
  bool statistics = false;
  bool topology = false;
  bool json = false;
  bool fast = false;
  std::string deviation;
  bool map_normals = false;
};

Error unlisted(const std::string& name, const std::string& value, const std::string& known) {
  return refused(name + " must be one of " + known + ", not '" + value + "'", "", name);
}

template <class Enum, std::size_t N>
Result<Done> set_name(const api::Name<Enum> (&table)[N], const std::string& name, const std::string& text, Enum& out) {
  const auto found = api::value_of(table, text);
  if (!found) return unlisted(name, text, api::list_of(table));
  return out = *found, Done{};
}

template <class Number>
Result<Done> set_number(const std::optional<double>& value, const api::Range& range, const char* name, Number& out) {
  if (!value) return Done{};
  auto checked = api::in_range(*value, range, name);
  if (!checked) return checked.error();
  return out = static_cast<Number>(*checked), Done{};
}

Result<Done> set_tolerance(const Flags& flags, Tolerance& tolerance) {
  if (!flags.absolute && !flags.diagonal && !flags.relative) return Done{};
  tolerance = {};
  if (auto ok = set_number(flags.absolute, api::kToleranceRange, "--absolute", tolerance.absolute); !ok) return ok;
  if (auto ok = set_number(flags.diagonal, api::kToleranceRange, "--diagonal", tolerance.diagonal); !ok) return ok;
  return set_number(flags.relative, api::kToleranceRange, "--relative", tolerance.relative);
}

Result<Done> set_points(const Flags& flags, Options& options) {
  if (flags.points) {
    auto points = api::as_points(*flags.points, "--points");
    if (!points) return points.error();
    options.points = *points;
  }
  return api::check_points(flags.points.has_value(), options.strategy, "--points");
}

Result<Done> set_budget(const Flags& flags, Options& options) {
  const auto ok = set_number(flags.work_items, api::kWorkItemsRange, "--work-items", options.max_work_items);
  if (!ok) return ok;
  return set_number(flags.memory_bytes, api::kMemoryBytesRange, "--memory-bytes", options.max_memory_bytes);
}

// A distance of compare is no share of the diagonal.
Result<Done> set_limits(const Flags& flags, api::ComparisonOptions& options) {
  check::Gate gate;
  if (flags.max_distance) {
    const auto limit = check::parse_length(*flags.max_distance);
    if (!limit) return refused("--max-distance " + limit.error().message, "", "--max-distance");
    gate.limit = *limit;
  }
  if (auto ok = read_flag("--max-share-beyond", flags.max_share_beyond, check::parse_area_limit, gate.area_limit); !ok)
    return ok;
  if (gate.area_limit && gate.area_limit->distance.max_diagonal_share)
    return bad_flag("--max-share-beyond", "the distance must be a length, such as 0.05 mm, not a share");
  if (auto ok = read_flag("--zone", flags.zone, check::parse_zone, gate.zone); !ok) return ok;
  if (gate.zone && (gate.zone->inside.max_diagonal_share || gate.zone->outside.max_diagonal_share))
    return bad_flag("--zone", "both limits must be lengths, such as -0.05 mm, 0.1 mm, not shares");
  if (auto ok = read_flag("--uncertainty", flags.uncertainty, check::parse_length, gate.uncertainty); !ok) return ok;
  if (auto ok = read_flag("--regions", flags.regions, check::parse_regions, gate.regions); !ok) return ok;
  if (const auto ok = check::check_limits(gate); !ok)
    return bad_flag(flag_beside(flags.uncertainty, flags.zone), ok.error().message);
  const check::Limits limits = check::limits_of(gate, 0);
  options.max_distance = limits.max_distance;
  options.max_share_beyond = limits.max_share_beyond;
  options.regions = limits.regions;
  options.zone = limits.zone;
  options.uncertainty = limits.uncertainty;
  if (auto ok = api::check_limits_of_regions(options, "--regions"); !ok) return ok;
  options.units.limit = check::main_limit(gate).unit;
  if (flags.fast && !has_limit(options))
    return bad_flag("--fast", "needs --max-distance, --max-share-beyond or --zone");
  options.narrow = has_limit(options) && !flags.fast;
  return Done{};
}

Result<Done> set_statistics(const Flags& flags, Options& options) {
  Sampling sampling;
  if (auto ok = set_number(flags.samples, api::kSamplesRange, "--samples", sampling.samples); !ok) return ok;
  if (auto ok = set_number(flags.seed, api::kSeedRange, "--seed", sampling.seed); !ok) return ok;
  if (flags.statistics) return options.statistics = sampling, Done{};
  if (!flags.samples && !flags.seed) return Done{};
  const std::string name = flags.samples ? "--samples" : "--seed";
  return refused(name + " goes with --statistics only", "", name);
}

Result<Done> set_list(const std::vector<double>& values, const api::Range& range, std::size_t most, const char* name) {
  if (values.size() > most) {
    const std::string limit = std::to_string(most) + " values, not " + std::to_string(values.size());
    return refused(std::string(name) + " takes at most " + limit, "", name);
  }
  for (const double value : values) {
    if (auto ok = api::in_range(value, range, name); !ok) return ok.error();
  }
  return Done{};
}

Result<Done> set_areas(const Flags& flags, Options& options) {
  AreaOptions asked;
  if (auto ok = set_list(flags.beyond, api::kBeyondRange, AreaOptions::kMaxBeyond, "--beyond"); !ok) return ok;
  if (auto ok = set_list(flags.quantiles, api::kQuantileRange, AreaOptions::kMaxQuantiles, "--quantiles"); !ok)
    return ok;
  for (const double distance : flags.beyond) asked.beyond.push_back({distance, std::nullopt});
  asked.quantiles = flags.quantiles;
  asked.mean = flags.mean;
  const auto& [share, length] = std::tie(flags.share_tolerance, flags.length_tolerance);
  if (!asks_something(asked)) {
    if (!share && !length) return Done{};
    const std::string name = share ? "--share-tolerance" : "--length-tolerance";
    return refused(name + " goes with --beyond, --quantiles or --mean", "", name);
  }
  if (auto ok = set_number(share, api::kShareToleranceRange, "--share-tolerance", asked.share_tolerance); !ok)
    return ok;
  if (auto ok = set_number(length, api::kLengthToleranceRange, "--length-tolerance", asked.length_tolerance); !ok)
    return ok;
  return options.areas = std::move(asked), Done{};
}

Result<Done> set_sides(const Flags& flags, api::ComparisonOptions& options) {
  if (flags.sides) options.sides.emplace();
  const char* name = flags.zone ? "--zone" : "--sides";
  if (const auto ok = api::check_sides(options, name); !ok) return refused(ok.error().message, "", name);
  if (const auto ok = api::check_groups(options, "--regions"); !ok) return bad_flag("--regions", ok.error().message);
  return Done{};
}

Result<Done> set_machine(const Flags& flags, Options& options) {
  auto threads = api::in_range(flags.threads, {0, api::kThreadsRange.high, true}, "--threads");
  if (!threads) return threads.error();
  const auto most = static_cast<unsigned>(api::kThreadsRange.high);
  options.threads = static_cast<unsigned>(*threads);
  if (options.threads == 0) options.threads = std::min(api::processors(), most);
  auto simd = api::as_simd(flags.simd, "--simd");
  if (!simd) return simd.error();
  return options.simd = *simd, Done{};
}

Result<api::Request> to_request(const Flags& flags) {
  api::Request request;
  api::ComparisonOptions& options = request.options;
  if (auto ok = set_name(api::kDirectionWords, "--direction", flags.direction, options.direction); !ok)
    return ok.error();
  if (auto ok = set_name(api::kStrategies, "--strategy", flags.strategy, options.strategy); !ok) return ok.error();
  if (auto ok = set_points(flags, options); !ok) return ok.error();
  if (auto ok = set_tolerance(flags, options.tolerance); !ok) return ok.error();
  if (auto ok = set_budget(flags, options); !ok) return ok.error();
  if (auto ok = set_limits(flags, options); !ok) return ok.error();
  if (auto ok = set_units(flags.units, options.units); !ok) return ok.error();
  if (auto ok = set_areas(flags, options); !ok) return ok.error();
  if (auto ok = set_sides(flags, options); !ok) return ok.error();
  if (auto ok = set_statistics(flags, options); !ok) return ok.error();
  if (auto ok = set_machine(flags, options); !ok) return ok.error();
  if (auto ok = set_align(flags.align, options.align); !ok) return ok.error();
  if (auto ok = read_flag("--expect", flags.expect, check::parse_expect, options.expect); !ok) return ok.error();
  options.topology = flags.topology;
  auto timeout = api::in_range(flags.timeout_ms, api::kTimeoutMsRange, "--timeout-ms");
  if (!timeout) return timeout.error();
  request.timeout = std::chrono::milliseconds(static_cast<std::int64_t>(*timeout));
  return request;
}

// Shows the interval on one line of the terminal while the work runs.
void show_progress(Control& control) {
  using std::chrono::milliseconds;
  control.watch(
      [](const Progress& progress) {
        std::fprintf(stderr, "\r\033[K%-9s %s .. %s", progress.stage, check::shortest(progress.lower).c_str(),
                     check::shortest(progress.upper).c_str());
        std::fflush(stderr);
      },
      milliseconds(100));
}

// Writes A coloured by its distance from B. Has the time of the measurement once more, whose deadline may have passed.
Result<Done> write_map(const Flags& flags, const api::SharedMeshes& meshes, const api::Comparison& comparison,
                       std::chrono::milliseconds time) {
  const auto facts = api::result_facts(nlohmann::ordered_json::parse(api::to_json(comparison)), api::Side::a);
  if (!facts) return facts.error();
  Control control(Control::Clock::now() + time);
  const Interrupts interrupts(&control);
  const auto pair = api::in_unit_of_result(meshes.a, meshes.b, facts->units, facts->motion, control);
  if (!pair) return pair.error();
  if (!facts->no_sides.empty())
    std::fprintf(stderr, "meshgauge: '%s' has no signed distance: %s\n", flags.deviation.c_str(),
                 facts->no_sides.c_str());
  const check::DeviationFile map{flags.deviation, check::Refine::by_format, comparison.options.threads,
                                 flags.map_normals};
  return check::write_deviation(map, *pair->a, *pair->b, *facts, control);
}

Result<Done> check_deviation(const Flags& flags) {
  Places places;
  places.reads(flags.a, "mesh A");
  places.reads(flags.b, "mesh B");
  const auto map = DeviationMaps::open(flags.deviation, false, {}, places);
  if (!map) return map.error();
  return Done{};
}

Result<api::Comparison> measure_files(const Flags& flags, const api::Request& request, api::SharedMeshes& meshes) {
  if (auto ok = check_deviation(flags); !ok) return ok.error();
  const auto files = with_pipes(flags.a, flags.b);
  if (!files) return files.error();
  const auto a = api::MeshFile::open(files->a, files->pipes.get());
  if (!a) return a.error();
  const auto b = api::MeshFile::open(files->b, files->pipes.get());
  if (!b) return b.error();
  Control control(Control::Clock::now() + request.timeout);
  const Interrupts interrupts(&control);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal) show_progress(control);
  auto comparison = api::compare({files->a, a->bytes(), files->a, ""}, {files->b, b->bytes(), files->b, ""},
                                 request.options, api::ReadLimits{}, control, &meshes);
  if (terminal) std::fputs("\r\033[K", stderr);
  return comparison;
}

// As of `check`. nullopt: nothing was limited or expected.
int exit_code_of(std::optional<api::Verdict> verdict) {
  if (!verdict || *verdict == api::Verdict::pass) return kExitResult;
  return *verdict == api::Verdict::fail ? kExitFail : kExitUndecided;
}

int run(const Flags& flags) {
  const auto request = to_request(flags);
  if (!request) return fail(request.error());
  use_huge_pages();
  api::SharedMeshes meshes;
  const auto comparison = measure_files(flags, *request, meshes);
  if (!comparison) return fail(comparison.error());
  const std::string text = flags.json ? api::to_json(*comparison) + "\n" : to_table(*comparison);
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) return fail({ErrorCode::internal, "the result could not be written", "", ""});
  if (!flags.deviation.empty()) {
    const auto map = write_map(flags, meshes, *comparison, request->timeout);
    if (!map) return fail(map.error());
  }
  return exit_code_of(api::worst(api::criteria_of(*comparison)));
}

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand(
      "compare",
      "Measure the distance between two mesh files; with a limit: exit 0 pass, 1 fail, 2 undecided, 3 error");
  const auto flags = std::make_shared<Flags>();
  command
      .add_option(
          "A", flags->a,
          "Mesh file: OBJ, STL, PLY, OFF, glTF, GLB, 3MF or XYZ, also gzip-compressed; .zip of a glTF; - for standard "
          "input")
      ->required();
  command.add_option("B", flags->b, "The mesh file to compare with")->required();
  command.add_option("--direction", flags->direction, api::list_of(api::kDirections))->capture_default_str();
  command.add_option("--absolute", flags->absolute, "Stop when upper - lower is at most this");
  command.add_option("--diagonal", flags->diagonal, "Stop when upper - lower is at most this part of A's diagonal");
  command.add_option("--relative", flags->relative, "Stop when upper - lower is at most this part of lower");
  command.add_option("--max-distance", flags->max_distance,
                     "Gate: stop when the distance is known to pass or fail; '0.05', or '0.05 mm'");
  command.add_option("--max-share-beyond", flags->max_share_beyond,
                     "Gate: the largest share of the area that may be farther than a distance; '0.05 mm: 1 %'");
  command.add_option("--zone", flags->zone,
                     "Gate: how far A may be inside and outside of B, a closed mesh; '-0.05 mm, 0.1 mm'");
  command.add_option("--uncertainty", flags->uncertainty,
                     "Of the distances: pass and fail only by more than this; '0.01 mm' (ISO 14253-1)");
  command.add_option("--regions", flags->regions, kRegionsHelp);
  command.add_flag("--fast", flags->fast, "End as soon as the gate is decided, without narrowing the interval");
  command.add_option("--expect", flags->expect, kExpectHelp);
  declare(command, flags->units, "A", "B");
  command.add_option("--align", flags->align, kAlignHelp);
  command.add_option("--strategy", flags->strategy, api::list_of(api::kStrategies))->capture_default_str();
  command.add_option("--points", flags->points, "Samples a piece, for the strategy n_point: 4, 10, 31, 109, 409, 1585");
  command.add_option("--timeout-ms", flags->timeout_ms, "Stop after this time, with the interval reached")
      ->capture_default_str();
  command.add_option("--work-items", flags->work_items, "Stop after splitting so many pieces");
  command.add_option("--memory-bytes", flags->memory_bytes, "Stop when the waiting pieces need more than this");
  command.add_option("--threads", flags->threads, "At most so many threads; 0: one for each processor")
      ->capture_default_str();
  command.add_option("--simd", flags->simd, "Instruction set: " + api::simd_names())->capture_default_str();
  command.add_option("--beyond", flags->beyond, "Certify the share of the area beyond these distances: 0.05,0.1")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--quantiles", flags->quantiles, "Certify the distances that these shares are within: 0.95,0.99")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_flag("--mean", flags->mean, "Certify the mean and the root mean square of the distance");
  command.add_option("--share-tolerance", flags->share_tolerance, "Width of a certified share; else 0.001");
  command.add_option("--length-tolerance", flags->length_tolerance,
                     "Width of a certified quantile or mean, relative to it; else 0.01");
  command.add_flag("--sides", flags->sides, "Certify how far A reaches outside and inside of B, which must be closed");
  command.add_flag("--statistics", flags->statistics, "Also sample mean, RMS, quantiles and a histogram");
  command.add_option("--samples", flags->samples, "Points sampled in each direction, 1000 to 1000000; else 100000");
  command.add_option("--seed", flags->seed, "Another one samples other points; else 1");
  command.add_flag("--topology", flags->topology,
                   "Also examine both meshes: open edges, orientation, components, volume");
  command.add_option(
      "--deviation,--map", flags->deviation,
      "Write A coloured by its distance from B: FILE.ply, .glb, .vtp or .csv; signed with --sides, --zone");
  command.add_flag("--map-normals", flags->map_normals, "Also write the normal of each vertex to the deviation map")
      ->needs("--deviation");
  command.add_flag("--json", flags->json, "Print the result as JSON");
  command.callback([flags, &exit_code] { exit_code = run(*flags); });
}

}  // namespace meshgauge::cli
