// glTF files made by the tests: a tetrahedron, whole or with one member changed.
#pragma once

#include <string>

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"
#include "tests/api/formats/gltf_documents.h"

namespace meshgauge::api::test {

inline Mesh mesh_of(const std::string& file) {
  auto result = read(file, "");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(result->mesh);
}

// The refusal of the tetrahedron with one member replaced.
inline std::string refused(const std::string& pointer, const json& value) {
  json document = tetrahedron();
  document[json::json_pointer(pointer)] = value;
  return refusal(glb(document), "m.glb");
}

inline std::string refused_without(const std::string& pointer, const std::string& member) {
  json document = tetrahedron();
  document[json::json_pointer(pointer)].erase(member);
  return refusal(glb(document), "m.glb");
}

}  // namespace meshgauge::api::test
