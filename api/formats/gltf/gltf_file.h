// Context shared by the readers of a glTF's parts.
#pragma once

#include <string>

#include <tiny_gltf.h>

#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_accessor.h"
#include "api/formats/gltf/gltf_document.h"
#include "api/formats/gltf/gltf_views.h"

namespace meshgauge::api {

// Borrows its members. Precondition: model and document come from check_gltf().
struct GltfFile {
  const Source& source;
  const tinygltf::Model& model;
  const GltfDocument& document;
  GltfViews& views;
  const GltfAccessors& accessors;
  GltfBudget& budget;

  Error fail(const std::string& where, const std::string& what) const {
    return at(source, where, ErrorCode::unreadable_mesh, what);
  }
};

// Returns the place of an item in messages: "nodes[3]".
inline std::string gltf_item(const char* array, std::size_t index) {
  return array + ("[" + std::to_string(index) + "]");
}

}  // namespace meshgauge::api
