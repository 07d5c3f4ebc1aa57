// A deviation map for the tests of its writers: a cube's candidate with a distance at each vertex.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "api/formats/format.h"
#include "api/map/deviation_map.h"
#include "shapes.h"

namespace meshgauge::api::test {

// Owns the arrays that a map borrows.
struct MadeMap {
  Mesh mesh;
  std::vector<double> distances;
  DeviationMap map;

  explicit MadeMap(Mesh of) : mesh(std::move(of)) {
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) distances.push_back(static_cast<double>(v) / 30);
    map.mesh = mesh;
    map.candidate_vertices = mesh.positions.size();
    map.candidate_triangles = mesh.triangles.size();
    map.distances = distances;
    map.scale = {0.125, true};
    map.units = "mm";
    map.lower = 0.23;
    map.upper = 0.25;
    map.witness = ResultWitness{false, {0.5, 2, 3}, 7, {0.5, 1, 3}, 11};
  }
  MadeMap(const MadeMap&) = delete;
  MadeMap& operator=(const MadeMap&) = delete;
};

inline Mesh read_back(const std::string& file) {
  auto read = read_mesh(std::as_bytes(std::span<const char>(file)), {"a", "", ""}, {});
  return read ? std::move(read->mesh) : Mesh{};
}

}  // namespace meshgauge::api::test
