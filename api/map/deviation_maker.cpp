#include "api/map/deviation_maker.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "api/compare/load.h"
#include "engine/extras/display/decimation.h"
#include "engine/extras/display/deviation.h"
#include "engine/extras/display/refinement.h"

namespace meshgauge::api {
namespace {

constexpr double kLongestEdge = 1.0 / 64;  // times the diagonal
constexpr const char* kWhat = "the deviation map was made";

// Returns the rank of each vertex for decimation: highest for the farthest vertex, then by distance for vertices beyond
// the limit, 0 for all others.
std::vector<std::uint8_t> ranks(const Deviation& deviations, const ColourScale& scale) {
  constexpr double kLevels = 253;
  const double farthest = deviations.distances[deviations.farthest];
  std::vector<std::uint8_t> rank(deviations.distances.size());
  std::transform(deviations.distances.begin(), deviations.distances.end(), rank.begin(), [&](double distance) {
    if (!scale.limited || distance <= scale.top) return std::uint8_t{0};
    return static_cast<std::uint8_t>(1 + kLevels * ((distance - scale.top) / (farthest - scale.top)));
  });
  rank[deviations.farthest] = std::numeric_limits<std::uint8_t>::max();
  return rank;
}

// Lengths are shares of the diagonal, so that products neither vanish nor overflow.
std::vector<Vec3> vertex_normals(MeshView mesh, const Box& box) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3::Zero());
  const double scale = 1 / diagonal(box);
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3 a = scale * mesh.positions[triangle[0]];
    const Vec3 normal = (scale * mesh.positions[triangle[1]] - a).cross(scale * mesh.positions[triangle[2]] - a);
    for (const std::uint32_t v : triangle) normals[v] += normal;
  }
  for (Vec3& normal : normals) {
    const double length = norm(normal);
    normal = length > 0 && std::isfinite(length) ? Vec3(normal / length) : Vec3::UnitZ();
  }
  return normals;
}

// Returns the values at these places; `values` may be empty.
template <class T>
std::vector<T> picked(const std::vector<T>& values, const std::vector<std::uint32_t>& places) {
  std::vector<T> kept;
  for (std::size_t i = 0; i < places.size() && !values.empty(); ++i) kept.push_back(values[places[i]]);
  return kept;
}

// Returns the numbers of `most` points, evenly spread over the file, the farthest one among them.
std::vector<std::uint32_t> thinned(std::size_t points, std::size_t most, std::uint32_t farthest) {
  std::vector<std::uint32_t> kept;
  const std::size_t step = most > 1 ? (points + most - 2) / (most - 1) : points;  // leaves room for the farthest
  for (std::size_t v = 0; v < points; ++v) {
    if (v != farthest && (most == 1 || v % step != 0)) continue;
    kept.push_back(static_cast<std::uint32_t>(v));
  }
  return kept;
}

ColourScale scale_of(const ResultFacts& facts, const Deviation& deviations) {
  if (facts.limit) return {facts.limit->limit, true};
  return {deviations.distances[deviations.farthest], false};
}

}  // namespace

Result<MadeMap> make_deviation(const Prepared& candidate, const Prepared& baseline, const ResultFacts& facts,
                               const MapOptions& options, Control& control) {
  const auto stopped = [&control] { return control.check() != Interruption::none; };
  const std::size_t triangles = candidate.mesh().triangles.size();
  MadeMap made;
  MapForm form = triangles > options.max_triangles ? MapForm::decimated : MapForm::as_is;
  if (options.refine && form == MapForm::as_is) {
    const std::size_t most = std::min(MapOptions::kMostRefined, options.max_triangles);
    if (auto more = refined(candidate.mesh(), {kLongestEdge * diagonal(candidate.box()), most}, stopped)) {
      made.shown_ = std::move(*more);
      form = MapForm::refined;
    }
  }
  const double upper = facts.direction ? facts.direction->upper : std::numeric_limits<double>::infinity();
  std::optional<Prepared> display;
  if (form == MapForm::refined)
    display.emplace(made.shown_, Prepared::Use::once, nullptr, std::nullopt, candidate.error());
  const bool signs = facts.sides && facts.no_sides.empty();
  auto deviations =
      deviation(display ? *display : candidate, baseline, {options.threads, options.simd, upper, signs}, control);
  if (!deviations) return not_in_time(control.check(), kWhat);
  const ColourScale scale = scale_of(facts, *deviations);
  const bool cloud = is_cloud(candidate.mesh());
  if (options.normals && !cloud)
    made.normals_ = vertex_normals(display ? display->mesh() : candidate.mesh(), candidate.box());
  std::vector<std::uint32_t> source;  // the vertices of a decimated map
  if (form == MapForm::decimated && cloud) {
    source = thinned(candidate.mesh().positions.size(), options.max_triangles, deviations->farthest);
    for (const std::uint32_t v : source) made.shown_.positions.push_back(candidate.mesh().positions[v]);
    made.shown_.triangles = points_as_triangles(source.size());
  } else if (form == MapForm::decimated) {
    auto fewer = decimated(candidate.mesh(), {options.max_triangles, ranks(*deviations, scale)}, stopped);
    if (!fewer) return not_in_time(control.check(), kWhat);
    made.shown_ = std::move(fewer->mesh);
    source = std::move(fewer->source);
  }
  const bool is_whole = form != MapForm::decimated;
  made.distances_ = is_whole ? std::move(deviations->distances) : picked(deviations->distances, source);
  made.sides_ = is_whole ? std::move(deviations->sides) : picked(deviations->sides, source);
  if (!is_whole) made.normals_ = picked(made.normals_, source);
  const auto& unit = facts.units.result.unit;
  made.map_ = {form == MapForm::as_is ? candidate.mesh() : MeshView(made.shown_),
               form,
               candidate.mesh().positions.size(),
               cloud ? 0 : triangles,
               made.distances_,
               made.sides_,
               signs && made.sides_.empty() ? "the baseline has no sides" : facts.no_sides,
               made.normals_,
               scale,
               facts.limit ? facts.limit->side : std::string(),
               std::string(to_string(unit)),
               facts.lower,
               facts.upper,
               facts.witness,
               facts.direction};
  return made;
}

}  // namespace meshgauge::api
