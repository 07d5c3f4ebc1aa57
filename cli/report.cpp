#include "cli/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <limits>
#include <optional>

#include "api/base/figures.h"
#include "api/options/gate.h"
#include "api/options/names.h"
#include "api/result/criteria.h"
#include "api/result/json_of.h"
#include "api/result/notes.h"

namespace meshgauge::cli {
namespace {

using api::Comparison;
using Unit = std::optional<api::LengthUnit>;  // unit of all measured lengths

// Cut after 511 bytes.
__attribute__((format(printf, 1, 2))) std::string formatted(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

constexpr int kDigits = 6;

// "0.603022 .. 0.603023 mm", rounded outwards, with more digits where a limit needs them.
std::string range(double lower, double upper, const Unit& unit,
                  double limit = std::numeric_limits<double>::infinity()) {
  const api::IntervalText text = api::to_text(lower, upper, limit);
  return text.lower + " .. " + api::with_unit(text.upper, unit);
}

std::string reason(const Outcome& outcome) {
  std::string why(api::name_of(api::kStops, outcome.stop));
  if (outcome.met_by) why += " (" + std::string(api::name_of(api::kRules, *outcome.met_by)) + " tolerance)";
  return why;
}

// "mm (file)", "mm (assumed)", "unknown".
std::string described(const api::KnownUnit& known) {
  if (!known.unit) return "unknown";
  return std::string(api::to_string(*known.unit)) + " (" + std::string(api::to_string(known.source)) + ")";
}

void add_mesh(std::string& out, const char* name, const api::MeshFacts& mesh, const api::KnownUnit& unit) {
  const std::string surface = mesh.notes.cloud ? "point cloud"
                                               : std::to_string(mesh.triangles) + " triangles (" +
                                                     std::to_string(mesh.degenerate) + " degenerate)";
  out += formatted("%-9s %s, %s, %zu vertices, diagonal %s, unit %s\n", name,
                   std::string(api::to_string(mesh.format)).c_str(), surface.c_str(), mesh.vertices,
                   api::to_digits(mesh.diagonal, kDigits).c_str(), described(unit).c_str());
  for (const std::string& note : api::notes_of(mesh)) out += "  " + note + "\n";
}

void add_edges(std::string& out, const char* kind, const EdgeCount& edges, const Unit& unit) {
  if (edges.count > 0)
    out += "          " + api::edges_in_words(edges.count, kind, edges.first, api::to_string(unit)) + "\n";
}

void add_topology(std::string& out, const char* name, const Topology& found, const Unit& unit) {
  const auto is = [](bool holds) { return holds ? "" : "not "; };
  out += formatted("%-9s %swatertight, %soriented, components %zu, Euler characteristic %lld", name,
                   is(found.watertight()), is(found.oriented()), found.components,
                   static_cast<long long>(found.euler_characteristic));
  if (found.volume)
    out += formatted(", volume %s%s", range(found.volume->lower, found.volume->upper, unit).c_str(), unit ? "^3" : "");
  out += "\n";
  add_edges(out, "open", found.open, unit);
  add_edges(out, "non-manifold", found.non_manifold, unit);
  add_edges(out, "flipped", found.flipped, unit);
}

// `from`: the mesh measured from.
void add_direction(std::string& out, const char* name, const std::optional<Directed>& directed,
                   const api::MeshFacts& from, const Unit& unit) {
  if (!directed) return;
  out += formatted("%-9s %s, culled %.2f %% (%zu of %zu %s left)\n", name,
                   range(directed->bounds.lower, directed->bounds.upper, unit).c_str(), 100 * directed->culling.rate(),
                   directed->culling.survivors, directed->culling.triangles, from.notes.cloud ? "points" : "triangles");
  if (const auto& witness = directed->bounds.witness) {
    out += formatted("  witness %s on %s %u\n", api::with_unit(api::in_words(witness->point_a), unit).c_str(),
                     from.notes.cloud ? "point" : "triangle", witness->triangle_a);
    out += formatted("  nearest %s on triangle %u\n", api::with_unit(api::in_words(witness->point_b), unit).c_str(),
                     witness->triangle_b);
  }
}

// "verdict   fail", and below it each criterion, the foremost first: "fail      the distance is at least ...".
void add_verdict(std::string& out, const Comparison& comparison) {
  const auto criteria = api::foremost_first(api::criteria_of(comparison));
  if (criteria.empty()) return;
  const std::string_view unit = api::to_string(comparison.units.result.unit);
  out += formatted("verdict   %s\n", std::string(api::to_string(criteria.front().verdict)).c_str());
  for (const api::Criterion& one : criteria)
    out += formatted("  %-9s ", std::string(api::to_string(one.verdict)).c_str()) + api::finding_of(one, unit) + "\n";
}

// "region    bore: 0.0101 .. 0.0103 mm".
void add_regions(std::string& out, const Comparison& comparison) {
  const auto& regions = comparison.outcome.regions;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const bool is_rest = i == comparison.options.regions.size();
    out += "region    " + (is_rest ? std::string(api::kRest) : comparison.options.regions[i].name) + ": ";
    out += regions[i].empty ? "no surface\n"
                            : range(regions[i].lower, regions[i].upper, comparison.units.result.unit) + "\n";
  }
}

void add_times(std::string& out, const Comparison& comparison) {
  const Timings& engine = comparison.outcome.timings;
  out += formatted("time      %.1f ms: read a %.1f, read b %.1f, build %.1f, traverse %.1f, reduce %.1f, certify %.1f",
                   comparison.times.total, comparison.times.read_a, comparison.times.read_b, engine.build,
                   engine.traverse, engine.reduce, engine.certify);
  if (comparison.alignment) out += formatted(", align %.1f", comparison.times.align);
  if (comparison.outcome.areas || comparison.outcome.sides) out += formatted(", areas %.1f", engine.areas);
  if (comparison.outcome.statistics) out += formatted(", statistics %.1f", engine.statistics);
  out += "\n";
}

void add_engine(std::string& out, const Comparison& comparison) {
  const Outcome& outcome = comparison.outcome;
  out += formatted("engine    %s, %s, %u %s\n",
                   std::string(api::name_of(api::kStrategies, comparison.options.strategy)).c_str(),
                   std::string(outcome.simd).c_str(), outcome.threads, outcome.threads == 1 ? "thread" : "threads");
}

// Certified areas, a few lines for each direction, and sides.

// Rounds the ends outwards to four decimals, so that what is printed holds.
std::string percent_range(const AreaInterval& share) {
  const double lower = std::max(0.0, std::floor(share.lower * 1e6 - 1e-6) / 1e4);
  const double upper = std::min(100.0, std::ceil(share.upper * 1e6 + (share.upper > 0 ? 1e-6 : 0)) / 1e4);
  return formatted("%.4f .. %.4f %%", lower, upper);
}

std::string length_range(const AreaInterval& length) {
  const api::IntervalText text = api::to_text(length.lower, length.upper, std::numeric_limits<double>::infinity());
  return text.lower + " .. " + text.upper;
}

std::string percentile(double share) {
  return formatted("p%.15g", 100 * share);  // 7, where 100 * 0.07 is a little more
}

std::string area_line(const std::string& what, const std::string& value) {
  return "  " + what + std::string(what.size() < 24 ? 24 - what.size() : 1, ' ') + value + "\n";
}

std::string area_lines(const char* name, const std::optional<AreaBounds>& found, const AreaOptions& asked,
                       const Unit& unit) {
  if (!found) return "";
  std::string out = std::string("certified ") + name + ": by area, lower .. upper" +
                    (unit ? api::with_unit(", in", unit) : "") + "\n";
  for (std::size_t k = 0; k < found->beyond.size(); ++k) {
    out += area_line("share beyond " + api::shortest(asked.beyond[k].distance), percent_range(found->beyond[k]));
  }
  for (std::size_t q = 0; q < found->quantiles.size(); ++q) {
    out += area_line(percentile(asked.quantiles[q]), length_range(found->quantiles[q]));
  }
  if (found->mean) out += area_line("mean", length_range(*found->mean));
  if (found->rms) out += area_line("rms", length_range(*found->rms));
  if (found->stop != AreaStop::complete) {
    out += area_line("ended by", std::string(api::name_of(api::kAreaStops, found->stop)));
  }
  return out;
}

std::string to_table(const AreaOutcome& areas, const Unit& unit) {
  return area_lines("a to b", areas.a_to_b, areas.options, unit) +
         area_lines("b to a", areas.b_to_a, areas.options, unit);
}

std::string to_table(const SideOutcome& sides, const Unit& unit) {
  std::string out =
      "certified a to b: by side of b, lower .. upper" + (unit ? api::with_unit(", in", unit) : std::string()) + "\n";
  if (sides.refused) return out + area_line("none", api::in_words(*sides.refused, unit));
  out += area_line("outside", length_range({sides.outside.lower, sides.outside.upper}));
  out += area_line("inside", length_range({sides.inside.lower, sides.inside.upper}));
  if (sides.stop != AreaStop::complete)
    out += area_line("ended by", std::string(api::name_of(api::kAreaStops, sides.stop)));
  return out;
}

// Sampled statistics: for each direction a line of numbers and a histogram.

constexpr double kBarWidth = 50;  // in characters
constexpr std::size_t kBinsALine = 2;

std::string number_line(const char* name, const Estimate& estimate) {
  return formatted("  %-9s %-12.6g +- %.2g\n", name, estimate.value, estimate.standard_error);
}

// Returns bars in proportion to the longest one.
std::string bars(const Distribution& found) {
  std::array<double, Distribution::kBins / kBinsALine> shares{};
  for (std::size_t b = 0; b < found.histogram.size(); ++b) shares[b / kBinsALine] += found.histogram[b].value;
  const double longest = *std::max_element(shares.begin(), shares.end());
  const double step = found.max_seen / static_cast<double>(shares.size());
  std::string out;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto length = static_cast<std::size_t>(std::lround(shares[i] / longest * kBarWidth));
    out += formatted("  up to %-12.6g %6.2f %%%s\n", step * static_cast<double>(i + 1), 100 * shares[i],
                     (length > 0 ? " " + std::string(length, '#') : "").c_str());
  }
  return out;
}

std::string direction(const char* name, const std::optional<Distribution>& found, const Unit& unit) {
  if (!found) return "";
  std::string out = formatted("sampled   %s: %zu points by %s, value +- standard error%s\n", name, found->samples,
                              std::string(api::name_of(api::kWeights, found->weight)).c_str(),
                              unit ? api::with_unit(", in", unit).c_str() : "");
  out += number_line("mean", found->mean) + number_line("rms", found->rms) + number_line("p50", found->p50) +
         number_line("p95", found->p95) + number_line("p99", found->p99);
  return out + formatted("  %-9s %.6g\n", "max seen", found->max_seen) + bars(*found);
}

std::string to_table(const Statistics& statistics, const Unit& unit) {
  std::string out = direction("a to b", statistics.a_to_b, unit) + direction("b to a", statistics.b_to_a, unit);
  if (statistics.status != StatisticsStatus::complete) {
    out += "sampled   not everything that was asked for: " +
           std::string(api::name_of(api::kStatisticsStatuses, statistics.status)) + "\n";
  }
  return out;
}

}  // namespace

std::string to_table(const Comparison& comparison) {
  const Outcome& outcome = comparison.outcome;
  const Unit& unit = comparison.units.result.unit;
  const double limit = comparison.options.max_distance.value_or(std::numeric_limits<double>::infinity());
  std::string out;
  out += formatted("distance  %s, %s\n", range(outcome.lower, outcome.upper, unit, limit).c_str(),
                   std::string(api::name_of(api::kDirections, comparison.options.direction)).c_str());
  out += formatted("width     %s, %s\n",
                   api::with_unit(api::to_digits_above(outcome.upper - outcome.lower, 3), unit).c_str(),
                   reason(outcome).c_str());
  add_verdict(out, comparison);
  add_regions(out, comparison);
  add_direction(out, "a to b", outcome.a_to_b, comparison.a, unit);
  add_direction(out, "b to a", outcome.b_to_a, comparison.b, unit);
  if (outcome.areas) out += to_table(*outcome.areas, unit);
  if (outcome.sides) out += to_table(*outcome.sides, unit);
  if (outcome.statistics) out += to_table(*outcome.statistics, unit);
  add_mesh(out, "mesh a", comparison.a, comparison.units.a);
  add_mesh(out, "mesh b", comparison.b, comparison.units.b);
  if (comparison.a.topology) add_topology(out, "a is", *comparison.a.topology, unit);
  if (comparison.b.topology) add_topology(out, "b is", *comparison.b.topology, unit);
  for (const std::string& note : api::notes_of(comparison)) out += "note      " + note + "\n";
  add_engine(out, comparison);
  add_times(out, comparison);
  return out;
}

}  // namespace meshgauge::cli
