#include "api/result/notes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "api/base/figures.h"
#include "api/result/criteria.h"

namespace meshgauge::api {
namespace {

void add_count(std::vector<std::string>& notes, const std::string& what, std::size_t count) {
  if (count != 0) notes.push_back(what + ": " + std::to_string(count));
}

void add_contradiction(std::vector<std::string>& notes, const char* hint, std::optional<Format> said, Format is) {
  if (!said) return;
  notes.push_back(std::string(hint) + " says " + std::string(to_string(*said)) + ", but the content is " +
                  std::string(to_string(is)) + "; it was read as that");
}

std::string words(LengthUnit unit) { return std::string(in_words(unit)); }

void add_units(std::vector<std::string>& notes, const char* mesh, const KnownUnit& known, const MeshFacts& facts,
               const KnownUnit& result) {
  const auto& file = facts.notes.unit;
  if (known.source == UnitSource::declared && file && known.unit != file) {
    notes.push_back(std::string(mesh) + " was taken to be in " + words(*known.unit) +
                    " as declared, though its file is in " + words(*file));
  }
  if (factor_between(known, result).is_one()) return;
  notes.push_back(std::string(mesh) + " was converted from " + words(*known.unit) + " to " + words(*result.unit));
}

// Two units whose numbers for the same length differ by the factor `ratio`.
struct LikelyUnits {
  double ratio;
  LengthUnit longer;  // has the smaller numbers
  LengthUnit shorter;
};
constexpr LikelyUnits kLikelyUnits[] = {
    {1000, LengthUnit::meter, LengthUnit::millimeter}, {25.4, LengthUnit::inch, LengthUnit::millimeter},
    {100, LengthUnit::meter, LengthUnit::centimeter},  {12, LengthUnit::foot, LengthUnit::inch},
    {1 / 0.0254, LengthUnit::meter, LengthUnit::inch}, {10, LengthUnit::centimeter, LengthUnit::millimeter}};
constexpr double kNearly = 0.02;

void add_scale(std::vector<std::string>& notes, const Comparison& comparison) {
  const UnitPlan& units = comparison.units;
  const auto size = [&](const MeshFacts& mesh, const KnownUnit& known) {
    const Factor factor = factor_between(known, units.result);
    return mesh.diagonal * factor.times / factor.over;
  };
  const double a = size(comparison.a, units.a), b = size(comparison.b, units.b);
  const double ratio = std::max(a, b) / std::min(a, b);
  const auto* likely = std::find_if(std::begin(kLikelyUnits), std::end(kLikelyUnits), [&](const LikelyUnits& one) {
    return std::abs(ratio / one.ratio - 1) <= kNearly;  // false for NaN
  });
  if (likely == std::end(kLikelyUnits)) return;
  const bool a_is_larger = a > b;
  char times[32];
  std::snprintf(times, sizeof times, "%.4g", ratio);
  const std::string larger = a_is_larger ? "mesh a" : "mesh b", smaller = a_is_larger ? "mesh b" : "mesh a";
  notes.push_back(larger + " is about " + times + " times as large as " + smaller + ", as if " + larger + " were in " +
                  words(likely->shorter) + " and " + smaller + " in " + words(likely->longer) +
                  ": if so, declare the unit of each mesh");
}

void add_polygons(std::vector<std::string>& notes, const PolygonNotes& polygons) {
  add_count(notes, "faces of more than three corners, split into triangles", polygons.count);
  add_count(notes, "concave faces among them, split by ear clipping", polygons.concave);
  add_count(notes, "faces that cross themselves, whose surface is ambiguous", polygons.self_crossing);
  if (polygons.non_planar == 0) return;
  add_count(notes,
            "faces that are not planar, whose surface is ambiguous (two splits of a face are at most " +
                shortest(polygons.largest_deviation) + " apart)",
            polygons.non_planar);
}

// Adds a note when the limit is so close to the deviation of splits that another split of one face could change the
// verdict.
void add_open(std::vector<std::string>& notes, const std::string& mesh, const KnownUnit& known, const MeshFacts& facts,
              const Comparison& comparison) {
  constexpr double kClose = 10;
  std::optional<double> limit;  // the smallest of the whole; that of the area only where max_distance is missing
  for (const Criterion& one : limits_asked(comparison.options)) {
    if (one.is_of_region() || (one.beyond && comparison.options.max_distance)) continue;
    const double length = one.beyond.value_or(one.limit);
    limit = std::min(limit.value_or(length), length);
  }
  const Factor factor = factor_between(known, comparison.units.result);
  const double apart = facts.notes.polygons.largest_deviation * factor.times / factor.over;
  if (!limit || !(*limit < kClose * apart)) return;
  const auto& unit = comparison.units.result.unit;
  const auto length = [&](double x) { return with_unit(shortest(x), unit); };
  notes.push_back(mesh + " has a face that is not planar and can be split into triangles that are up to " +
                  length(apart) + " apart; the limit " + length(*limit) +
                  " is less than ten times that: the verdict may depend on how such a face is split");
}

constexpr double kPoorFit = 0.02;  // RMS distance, of mesh a's diagonal

void add_alignment(std::vector<std::string>& notes, const Comparison& comparison) {
  if (!comparison.alignment) return;
  const auto& [found, moved] = *comparison.alignment;
  const bool fitted = comparison.options.align->fit;
  const auto brief = [](double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", x);
    return std::string(text);
  };
  const auto length = [&](double x) { return with_unit(brief(x), comparison.units.result.unit); };
  notes.push_back("mesh a was moved before it was measured, " +
                  std::string(fitted ? "by best fit" : "by the transform given") + ": turned by " + brief(moved.angle) +
                  " degrees, its centre shifted by " + length(moved.shift) + ", no point farther than " +
                  length(moved.largest) + "; RMS distance " + length(found.before) + " before, " +
                  length(found.residual) + " after");
  if (fitted && !comparison.options.align->principal_axes && found.residual > kPoorFit * comparison.outcome.diagonal_a)
    notes.push_back(
        "the best fit is a poor one: where the poses differ much, principal_axes finds a better one; where a part "
        "of mesh a has no counterpart, an overlap below 1 does");
  if (!found.converged)
    notes.push_back("the best fit ended after " + std::to_string(found.steps) +
                    " steps without converging: give a nearer pose as transform, or another overlap");
}

}  // namespace

std::vector<std::string> notes_of(const Comparison& comparison) {
  std::vector<std::string> notes;
  const UnitPlan& units = comparison.units;
  add_alignment(notes, comparison);
  add_units(notes, "mesh a", units.a, comparison.a, units.result);
  add_units(notes, "mesh b", units.b, comparison.b, units.result);
  if (units.a.unit.has_value() != units.b.unit.has_value()) {
    const bool knows_a = units.a.unit.has_value();
    notes.push_back(std::string("mesh ") + (knows_a ? "a" : "b") + " is in " +
                    words(knows_a ? *units.a.unit : *units.b.unit) + ", the unit of mesh " + (knows_a ? "b" : "a") +
                    " is not known: the numbers were compared without conversion");
  }
  add_scale(notes, comparison);
  add_open(notes, "mesh a", units.a, comparison.a, comparison);
  add_open(notes, "mesh b", units.b, comparison.b, comparison);
  return notes;
}

std::vector<std::string> notes_of(const MeshFacts& mesh) {
  std::vector<std::string> notes;
  if (mesh.notes.cloud) notes.push_back("a point cloud, without faces: the distance of each point is measured");
  add_contradiction(notes, "the file name", mesh.notes.filename_says, mesh.format);
  add_contradiction(notes, "the media type", mesh.notes.media_type_says, mesh.format);
  add_polygons(notes, mesh.notes.polygons);
  add_count(
      notes,
      "points, lines, faces of fewer than three corners and joins of strips, left out, since they have no surface",
      mesh.notes.skipped_primitives);
  add_count(notes, "objects outside of the build or the scene, left out", mesh.notes.unused_objects);
  add_count(notes, "objects and volumes that are not printed (support, modifiers, blockers), left out",
            mesh.notes.helper_objects);
  add_count(notes, "vertices merged with another at exactly the same position", mesh.notes.welded_vertices);
  add_count(notes, "triangles without area, kept as the segment or the point they span", mesh.degenerate);
  notes.insert(notes.end(), mesh.notes.remarks.begin(), mesh.notes.remarks.end());
  return notes;
}

}  // namespace meshgauge::api
