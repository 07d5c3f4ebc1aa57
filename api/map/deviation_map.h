// A deviation map: a mesh with its distance from the baseline at every vertex. Written as PLY
// (api/map/deviation_ply.h), GLB (api/map/deviation_glb.h), VTP (api/map/deviation_vtp.h) or CSV.
//
// The candidate is the mesh that is shown, the baseline the other one. Distances are measured from the candidate alone.
// No vertex shows what the baseline has and the candidate lacks; the witness does.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

#include "api/map/colour_map.h"
#include "api/result/result_document.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

// How the mesh shown differs from the candidate.
enum class MapForm {
  as_is,
  refined,    // more vertices (engine/extras/display/refinement.h); the candidate's own come first
  decimated,  // fewer vertices (engine/extras/display/decimation.h), all of them the candidate's
};

// Borrows the mesh and the distances.
struct DeviationMap {
  MeshView mesh;  // the candidate in the given form; passes validate()
  MapForm form = MapForm::as_is;
  std::size_t candidate_vertices = 0;   // counts of the candidate itself, before refining or decimating
  std::size_t candidate_triangles = 0;  // 0: a point cloud
  std::span<const double>
      distances;  // one per vertex, in the meshes' unit; finite and >= 0 (engine/extras/display/deviation.h)
  std::span<const std::int8_t> sides;  // one per vertex, as in engine/extras/display/deviation.h; empty: without signs
  std::string no_sides{};              // why there are none though they were asked for; empty: nothing to say
  std::span<const Vec3> normals{};     // one per vertex, of length 1 up to rounding; empty: without
  ColourScale scale;
  std::string limit_side{};  // "inside", "outside": the limit is of that side of the baseline; empty: of both
  std::string units;         // the unit's name; empty: not known
  double lower = 0;          // the certified interval of the comparison
  double upper = 0;
  std::optional<ResultWitness> witness;
  std::optional<ResultDirection> direction;  // from the candidate to the baseline; nullopt: not measured

  // The distance of a vertex, positive outside of the baseline and negative inside; NaN where the side is not proved,
  // but for a distance of 0. Precondition: there are sides.
  double signed_distance(std::size_t v) const {
    if (distances[v] == 0) return 0;
    return sides[v] == 0 ? std::numeric_limits<double>::quiet_NaN() : sides[v] * distances[v];
  }

  // Whether the mesh is written as points, without triangles.
  bool is_cloud() const { return candidate_triangles == 0; }
};

enum class MapKind { ply, glb, vtp, csv };

struct MapFormat {
  MapKind kind;
  std::string_view name;  // "ply"; with a point the suffix of a file
  std::string_view media_type;
};
inline constexpr MapFormat kMapFormats[] = {{MapKind::ply, "ply", "model/ply"},
                                            {MapKind::glb, "glb", "model/gltf-binary"},
                                            {MapKind::vtp, "vtp", "application/vnd.vtk.polydata"},
                                            {MapKind::csv, "csv", "text/csv"}};

constexpr const MapFormat& format_of(MapKind kind) { return kMapFormats[static_cast<std::size_t>(kind)]; }
static_assert(std::ranges::all_of(kMapFormats, [](const auto& one) { return format_of(one.kind).kind == one.kind; }));
// A GLB alone is for viewing: refined, or decimated (api/map/deviation_maker.h). The others have the candidate's
// vertices.
constexpr bool is_for_viewing(MapKind kind) { return kind == MapKind::glb; }

// Writes the map. The caller checks the state of `out`. Errors: those of write_deviation_glb().
Result<Done> write_deviation(const DeviationMap& map, MapKind kind, std::ostream& out);

}  // namespace meshgauge::api
