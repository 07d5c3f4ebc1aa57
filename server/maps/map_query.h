// The query of /v1/comparisons/{id}/deviation.ply, .glb, .vtp and .csv.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "api/base/problem.h"
#include "api/map/deviation_maker.h"

namespace meshgauge::server {

using api::MapKind;

struct MapQuery {
  MapKind kind = MapKind::ply;
  api::Side of = api::Side::a;               // the mesh that is shown
  std::optional<std::size_t> max_triangles;  // GLB only
  bool normals = false;

  // Unique among the maps of a comparison: "a.glb 20000".
  std::string name() const;
};

inline constexpr std::size_t kMostShownTriangles = std::size_t{1} << 30;

// Parses "of=b&max_triangles=20000&normals=true": known names alone, each at most once, without percent-encoding.
std::variant<MapQuery, api::Problem> parse_map_query(std::string_view query, MapKind kind);

}  // namespace meshgauge::server
