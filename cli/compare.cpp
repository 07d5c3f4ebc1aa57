#include "api/compare/compare.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "api/base/machine.h"
#include "api/compare/mesh_file.h"
#include "api/options/request.h"
#include "api/result/criteria.h"
#include "api/result/response.h"
#include "api/result/result_document.h"
#include "check/deviation.h"
#include "check/text.h"
#include "cli/check_extras.h"
#include "cli/commands.h"
#include "cli/heap.h"
#include "cli/interrupts.h"
#include "cli/option_flags.h"
#include "cli/pipes.h"
#include "cli/places.h"
#include "cli/report.h"

namespace meshgauge::cli {
namespace {

struct Flags {
  std::string a;
  std::string b;
  OptionFlags options;
  std::string simd = "auto";
  bool json = false;
  std::string deviation;
  bool map_normals = false;
};

Result<api::Request> to_request(const Flags& flags) {
  auto request = flags.options.request();
  if (!request) return request;
  if (!request->threads_given) {
    const auto most = static_cast<unsigned>(api::kThreadsRange.high);
    request->options.threads = std::min(api::processors(), most);
  }
  const auto simd = api::as_simd(flags.simd, "--simd");
  if (!simd) return simd.error();
  request->options.simd = *simd;
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
  const auto facts = api::result_facts(api::document_of(comparison), api::Side::a);
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
  flags->options.declare(command, OptionFlags::Command::compare);
  command.add_option("--simd", flags->simd, "Instruction set: " + api::simd_names())->capture_default_str();
  command.add_option(
      "--deviation,--map", flags->deviation,
      "Write A coloured by its distance from B: FILE.ply, .glb, .vtp or .csv; signed where sides are asked for");
  command.add_flag("--map-normals", flags->map_normals, "Also write the normal of each vertex to the deviation map")
      ->needs("--deviation");
  command.add_flag("--json", flags->json, "Print the result as JSON");
  command.callback([flags, &exit_code] { exit_code = run(*flags); });
}

}  // namespace meshgauge::cli
