// The mesh of a stand-in for the readers: a triangle for any bytes; the one of b is at distance 1 from the one of a.
#pragma once

#include <memory>

#include "api/compare/prepared_mesh.h"
#include "server/measure/mesh_source.h"

namespace meshgauge::server {

inline api::SharedMesh stand_in(const MeshSource& source) {
  const double z = source.input.part == "a" ? 0 : 1;
  const auto mesh = std::make_shared<const Mesh>(Mesh{{{0, 0, z}, {1, 0, z}, {0, 1, z}}, {{0, 1, 2}}});
  return std::make_shared<const api::PreparedMesh>(api::LoadedMesh{*mesh, api::Format::obj, {}, source.id, mesh},
                                                   source.input.bytes.size(), Prepared::Use::once);
}

}  // namespace meshgauge::server
