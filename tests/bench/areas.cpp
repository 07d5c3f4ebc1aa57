// Prints the time of certified areas (engine/area.h) beside that of the interval itself.
//
//   bench_areas MESH_A MESH_B [--pair NAME] [--threads N] [--seconds N] [--one-share]
//
// Measures both directions with a tolerance of 1e-4 of the diagonal, four times: alone, with a share (beyond half of
// the distance), with two (beyond an eighth of it, too), and with all else (p95, p99, mean, RMS), at the default
// tolerances. Prints one line of CSV:
//
//   pair, triangles of A and B, seconds of the interval (the median of up to five), of one share, of two shares, of
//   all, their three stop reasons, pieces of the shares and of all, the widest share and the widest relative length
//
// With --one-share it measures the first two only, and prints: pair, triangles of A and B, seconds of the interval, of
// the share, their quotient, the stop reasons, pieces and the wider share.
//
// The seconds of the areas are those of that stage alone. Exits with 1 and a message on stderr if a mesh cannot be
// read.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "api/options/names.h"
#include "engine/hausdorff.h"
#include "tests/bench/read.h"

namespace {

using namespace meshgauge;
using bench::read;

struct Run {
  const Mesh& a;
  const Mesh& b;
  unsigned threads;
  int seconds;

  Outcome operator()(const std::optional<AreaOptions>& areas) const {
    Options options;
    options.tolerance = {std::nullopt, 1e-4, std::nullopt};
    options.threads = threads;
    options.areas = areas;
    Control control(Control::Clock::now() + std::chrono::seconds(seconds));
    return measure(a, b, options, control);
  }
};

double seconds_of_interval(const Run& run) {
  std::vector<double> seconds;
  double sum = 0;
  while (seconds.size() < 5 && sum < 3) {
    const auto begun = std::chrono::steady_clock::now();
    run(std::nullopt);
    seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    sum += seconds.back();
  }
  std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2), seconds.end());
  return seconds[seconds.size() / 2];
}

struct Found {
  double seconds = 0;
  std::string stop;
  std::uint64_t pieces = 0;
  double widest_share = 0;
  double widest_length = 0;
};

Found found(const Outcome& outcome) {
  Found all{outcome.timings.areas / 1000, "", 0, 0, 0};
  for (const auto* bounds : {&outcome.areas->a_to_b, &outcome.areas->b_to_a}) {
    const AreaBounds& one = **bounds;
    all.stop += (all.stop.empty() ? "" : "/") + std::string(api::name_of(api::kAreaStops, one.stop));
    all.pieces += one.pieces;
    for (const auto& share : one.beyond) all.widest_share = std::max(all.widest_share, share.upper - share.lower);
    const auto widen = [&](const auto& length) {
      if (length.upper > 0) all.widest_length = std::max(all.widest_length, 1 - length.lower / length.upper);
    };
    for (const auto& length : one.quantiles) widen(length);
    if (one.mean) widen(*one.mean), widen(*one.rms);
  }
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  std::string path_a, path_b, pair;
  unsigned threads = 1;
  int seconds = 60;
  bool only_share = false;
  CLI::App app("Times certified areas.");
  app.add_option("a", path_a)->required();
  app.add_option("b", path_b)->required();
  app.add_option("--pair", pair);
  app.add_option("--threads", threads)->check(CLI::Range(1, 256));
  app.add_option("--seconds", seconds, "timeout of a measurement");
  app.add_flag("--one-share", only_share, "measure the interval and one share only");
  CLI11_PARSE(app, argc, argv);
  try {
    const Mesh a = read(path_a), b = read(path_b);
    const Run run{a, b, threads, seconds};
    const double interval = seconds_of_interval(run);
    const double upper = run(std::nullopt).upper;
    AreaOptions asked;
    asked.beyond = {{upper / 2, {}}};
    const Found half = found(run(asked));
    if (only_share) {
      std::printf("%s,%zu,%zu,%.5f,%.5f,%.1f,%s,%llu,%.2g\n", pair.c_str(), a.triangles.size(), b.triangles.size(),
                  interval, half.seconds, half.seconds / interval, half.stop.c_str(),
                  static_cast<unsigned long long>(half.pieces), half.widest_share);
      return 0;
    }
    asked.beyond.push_back({upper / 8, {}});
    const Found shares = found(run(asked));
    asked.quantiles = {0.95, 0.99};
    asked.mean = true;
    const Found all = found(run(asked));
    std::printf("%s,%zu,%zu,%.4f,%.4f,%.4f,%.4f,%s,%s,%s,%llu,%llu,%.2g,%.2g\n", pair.c_str(), a.triangles.size(),
                b.triangles.size(), interval, half.seconds, shares.seconds, all.seconds, half.stop.c_str(),
                shares.stop.c_str(), all.stop.c_str(), static_cast<unsigned long long>(shares.pieces),
                static_cast<unsigned long long>(all.pieces), std::max(shares.widest_share, all.widest_share),
                all.widest_length);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
