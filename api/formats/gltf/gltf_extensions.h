// The extensions of a glTF: which are known here and what each means for the surface; those that are read, without
// effect on it, or refused; and what the JSON says of the surface that is not read.
#pragma once

#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "api/formats/gltf/gltf_document.h"

namespace meshgauge::api {

enum class GltfEffect {
  read,     // `what`: the objects whose extension is read; elsewhere it is unknown
  none,     // no effect on the surface: ignored, also where it is required
  same,     // the file describes the same surface without it: ignored, refused where it is required
  noted,    // another surface beside the one that is read; `what` is the remark
  surface,  // is or changes surface; `what` is the kind that is counted as unread
  unknown,
};

struct GltfExtension {
  std::string_view name;
  GltfEffect effect = GltfEffect::unknown;
  std::string_view what = {};  // a plural
};

GltfExtension gltf_extension(std::string_view name);

// Returns whether a file that requires the extension can be read.
inline bool may_be_required(const GltfExtension& extension) {
  return extension.effect == GltfEffect::read || extension.effect == GltfEffect::none;
}

// Moves the extensions, the strides of views and each primitive's indices from `root`, the checked members, to `out`.
// Refuses a required extension by name, unless it is read or known not to affect the surface.
Result<Done> take_gltf_extensions(const Source& source, nlohmann::json& root, GltfDocument& out);

// Returns true when a buffer only replaces data that meshopt compresses.
bool is_gltf_fallback(const nlohmann::json& buffer);

// Adds to out.unread the extensions on meshes, primitives and nodes that are or change surface, or are unknown, and
// materials that displace it; to out.remarks animations and alternatives. Sets GltfFaces::foreign. Precondition:
// take_gltf_extensions() has taken the faces of `whole`.
void count_gltf_unread(const nlohmann::json& whole, GltfDocument& out);

}  // namespace meshgauge::api
