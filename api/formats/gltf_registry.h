// The extensions of glTF that are known here, and what each means for the surface.
#pragma once

#include <string_view>

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

}  // namespace meshgauge::api
