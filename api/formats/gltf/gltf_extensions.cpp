#include "api/formats/gltf/gltf_extensions.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace meshgauge::api {
namespace {

using nlohmann::json;

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

using enum GltfEffect;

constexpr GltfExtension kKnown[] = {
    {"KHR_draco_mesh_compression", read, "primitives"},
    {"EXT_meshopt_compression", read, "bufferViews"},
    {"KHR_meshopt_compression", read, "bufferViews"},
    {"KHR_mesh_quantization", read, "accessors"},
    {"EXT_mesh_gpu_instancing", read, "nodes"},
    {"KHR_node_visibility", read, "nodes"},

    {"KHR_materials_displacement", surface, "materials that displace the surface (KHR_materials_displacement)"},
    {"EXT_materials_displacement", surface, "materials that displace the surface (EXT_materials_displacement)"},
    {"EXT_primitive_voxels", surface, "primitives of voxels (EXT_primitive_voxels)"},
    {"EXT_implicit_ellipsoid_region", surface, "implicit ellipsoids (EXT_implicit_ellipsoid_region)"},
    {"EXT_implicit_cylinder_region", surface, "implicit cylinders (EXT_implicit_cylinder_region)"},
    {"EXT_text", surface, "texts (EXT_text)"},
    {"KHR_gaussian_splatting", surface, "primitives of Gaussian splats (KHR_gaussian_splatting)"},
    {"MPEG_primitive_V3C", surface, "primitives of coded volumetric video (MPEG_primitive_V3C)"},
    {"NEEDLE_progressive", surface, "finer levels of detail outside the file (NEEDLE_progressive)"},

    {"MSFT_lod", noted, "nodes with further levels of detail, of which the first is read (MSFT_lod)"},
    {"MAXAR_mesh_variants", noted,
     "nodes with variants of their mesh, of which the default is read (MAXAR_mesh_variants)"},
    {"AGI_articulations", noted, "nodes that articulations move, which are not applied (AGI_articulations)"},

    {"KHR_animation_pointer", none},
    {"KHR_techniques_webgl", none},
    {"KHR_technique_webgl", none},
    {"KHR_blend", none},
    {"MSFT_texture_dds", none},
    {"MSFT_packing_normalRoughnessMetallic", none},
    {"MSFT_packing_occlusionRoughnessMetallic", none},
    {"FB_ngon_encoding", none},
    {"FB_geometry_metadata", none},
    {"EXT_mesh_features", none},
    {"EXT_instance_features", none},
    {"EXT_structural_metadata", none},
    {"EXT_feature_metadata", none},
    {"CESIUM_primitive_outline", none},
    {"GODOT_single_root", none},
    {"AGI_stk_metadata", none},

    // Colliders and constraints act when a scene is simulated; the others select, describe or compress.
    {"KHR_physics_rigid_bodies", same},
    {"KHR_collision_shapes", same},
    {"KHR_node_hoverability", same},
    {"KHR_node_selectability", same},
    {"KHR_mesh_primitive_restart", same},
    {"EXT_mesh_primitive_restart", same},
    {"EXT_mesh_primitive_edge_visibility", same},
    {"EXT_mesh_manifold", same},
    {"MSFT_physics_rigid_body", same},
    {"MSFT_collision_primitives", same},
    {"MPEG_audio_spatial", same},
    {"VRMC_node_constraint", same},
    {"GRIFFEL_bim_data", same},
    {"NEEDLE_components", same},
    {"NEEDLE_gameobject_data", same},
    {"MOZ_hubs_components", same},
    {"EPIC_lightmap_textures", same},
    {"KHR_interactivity", same},
};

// Families that change materials, textures, lights, sounds or metadata.
constexpr std::string_view kHarmlessFamilies[] = {
    "KHR_materials_", "EXT_materials_",  "ADOBE_materials_", "NV_materials_", "KHR_texture_",
    "EXT_texture_",   "GOOGLE_texture_", "MPEG_texture_",    "KHR_lights_",   "EXT_lights_",
    "KHR_xmp",        "KHR_audio",       "MSFT_audio_",      "EXT_audio_"};

// Physics, sounds and places for users of virtual worlds; some name shapes, which are not shown.
constexpr std::string_view kSameFamilies[] = {"OMI_", "ASOBO_"};

bool is_in(std::span<const std::string_view> families, std::string_view name) {
  return std::ranges::any_of(families, [&](std::string_view family) { return name.starts_with(family); });
}

GltfExtension gltf_extension(std::string_view name) {
  const auto known = std::ranges::find(kKnown, name, &GltfExtension::name);
  if (known != std::end(kKnown)) return *known;
  if (is_in(kHarmlessFamilies, name)) return {name, none};
  return {name, is_in(kSameFamilies, name) ? same : unknown};
}

// Returns whether a file that requires the extension can be read.
bool may_be_required(const GltfExtension& extension) {
  return extension.effect == GltfEffect::read || extension.effect == GltfEffect::none;
}

constexpr std::string_view kMeshoptNames[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

Result<Done> check_required(const Source& source, const json& root, GltfDocument& out) {
  const auto names = [&](const char* key) { return root.value(key, std::vector<std::string>()); };
  for (const std::string& extension : names("extensionsRequired")) {
    if (may_be_required(gltf_extension(extension))) continue;
    return at(source, "extensionsRequired", ErrorCode::unsupported_format,
              "the extension " + in_quotes(extension) + " is not supported; save the model without it");
  }
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    out.quantized = out.quantized || std::ranges::count(names(key), "KHR_mesh_quantization") > 0;
  }
  return Done{};
}

std::optional<std::size_t> index_of(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) return std::nullopt;
  return found->get<std::size_t>();
}

// Returns the extension of an object; nullptr: it has none of this name.
const json* extension_of(const json& object, std::string_view name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return nullptr;
  const auto found = extensions->find(name);
  return found == extensions->end() ? nullptr : &*found;
}

GltfFaces faces_of(const json& primitive) {
  GltfFaces out;
  out.indices = index_of(primitive, "indices");
  if (const json* draco = extension_of(primitive, "KHR_draco_mesh_compression")) {
    out.draco.emplace();
    out.draco->view = (*draco)["bufferView"].get<std::size_t>();
    for (const auto& [name, id] : (*draco)["attributes"].items()) out.draco->ids[name] = id.get<std::uint32_t>();
  }
  return out;
}

GltfMeshopt meshopt_of(const json& extension) {
  GltfMeshopt out;
  out.buffer = extension["buffer"].get<std::size_t>();
  out.offset = extension.value("byteOffset", std::size_t{0});
  out.length = extension["byteLength"].get<std::size_t>();
  out.stride = extension["byteStride"].get<std::size_t>();
  out.count = extension["count"].get<std::size_t>();
  out.mode = extension["mode"].get<std::string>();
  out.filter = extension.value("filter", "NONE");
  return out;
}

void take_faces(json& root, GltfDocument& out) {
  for (json& mesh : root["meshes"]) {
    auto& faces = out.faces.emplace_back();
    for (json& primitive : mesh["primitives"]) {
      faces.push_back(faces_of(primitive));
      primitive.erase("indices");
      primitive.erase("extensions");
    }
  }
}

// Refuses a view with both extensions of meshopt: each forbids the other, and the choice would be arbitrary.
Result<Done> take_views(const Source& source, json& views, GltfDocument& out) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const std::string_view name : kMeshoptNames) {
      const json* found = extension_of(views[i], name);
      if (found == nullptr) continue;
      if (out.meshopt.contains(i)) {
        return at(source, "bufferViews[" + std::to_string(i) + "].extensions", ErrorCode::unreadable_mesh,
                  "has EXT_meshopt_compression and KHR_meshopt_compression; save the model with one of them");
      }
      out.meshopt[i] = meshopt_of(*found);
    }
    out.strides.push_back(index_of(views[i], "byteStride"));
    views[i].erase("byteStride");
    views[i].erase("extensions");
  }
  return Done{};
}

void take_node_extensions(json& nodes, GltfDocument& out) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (const json* found = extension_of(nodes[i], "EXT_mesh_gpu_instancing")) {
      const json& attributes = (*found)["attributes"];
      out.instancing[i] = {index_of(attributes, "TRANSLATION"), index_of(attributes, "ROTATION"),
                           index_of(attributes, "SCALE")};
    }
    const json* visibility = extension_of(nodes[i], "KHR_node_visibility");
    if (visibility != nullptr && !visibility->value("visible", true)) out.hidden.insert(i);
    nodes[i].erase("extensions");
  }
}

const json& array_of(const json& object, const char* name) {
  static const json kNone = json::array();
  const auto found = object.find(name);
  return found != object.end() && found->is_array() ? *found : kNone;
}

class Counter {
 public:
  explicit Counter(GltfDocument& out) : out_(out) {}

  // Counts the extensions of an object. `objects`: its kind, a plural. Returns true when one of them may hold surface
  // in place of what glTF itself defines.
  bool object(const json& item, std::string_view objects) {
    const auto extensions = item.is_object() ? item.find("extensions") : item.end();
    if (!item.is_object() || extensions == item.end() || !extensions->is_object()) return false;
    bool foreign = false;
    for (const auto& [name, content] : extensions->items()) foreign = extension(name, objects) || foreign;
    return foreign;
  }

  // Counts only materials that displace: any other change of a material leaves the surface where it is.
  void material(const json& item) {
    if (!item.is_object() || !item.contains("extensions") || !item["extensions"].is_object()) return;
    for (const auto& [name, content] : item["extensions"].items()) {
      if (gltf_extension(name).effect == GltfEffect::surface) extension(name, "materials");
    }
  }

  void remark(std::string_view what, std::size_t count) {
    if (count != 0) noted_[std::string(what)] += count;
  }

  void finish() {
    for (const auto& [what, count] : noted_) out_.remarks.push_back(what + ": " + std::to_string(count));
  }

 private:
  bool extension(std::string_view name, std::string_view objects) {
    const GltfExtension known = gltf_extension(name);
    switch (known.effect) {
      case GltfEffect::none:
      case GltfEffect::same:
        return false;
      case GltfEffect::noted:
        remark(known.what, 1);
        return false;
      case GltfEffect::surface:
        out_.unread.add(known.what);
        return true;
      case GltfEffect::read:
        if (known.what == objects) return false;
        break;
      case GltfEffect::unknown:
        break;
    }
    out_.unread.add("extensions " + std::string(name.substr(0, kLongestName)) + " on " + std::string(objects));
    return true;
  }

  static constexpr std::size_t kLongestName = 64;

  GltfDocument& out_;
  std::map<std::string, std::size_t> noted_;
};

}  // namespace

Result<Done> take_gltf_extensions(const Source& source, json& root, GltfDocument& out) {
  if (auto ok = check_required(source, root, out); !ok) return ok;
  if (root.contains("meshes")) take_faces(root, out);
  if (root.contains("bufferViews")) {
    if (auto ok = take_views(source, root["bufferViews"], out); !ok) return ok;
  }
  if (root.contains("nodes")) take_node_extensions(root["nodes"], out);
  for (const char* done : {"extensionsUsed", "extensionsRequired"}) root.erase(done);
  return Done{};
}

bool is_gltf_fallback(const json& buffer) {
  return std::ranges::any_of(kMeshoptNames, [&](std::string_view name) {
    const json* found = extension_of(buffer, name);
    return found != nullptr && found->value("fallback", false);
  });
}

void count_gltf_unread(const json& whole, GltfDocument& out) {
  Counter counter(out);
  const json& meshes = array_of(whole, "meshes");
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    counter.object(meshes[m], "meshes");
    const json& primitives = array_of(meshes[m], "primitives");
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      out.faces[m][p].foreign = counter.object(primitives[p], "primitives");
    }
  }
  for (const json& node : array_of(whole, "nodes")) counter.object(node, "nodes");
  for (const json& material : array_of(whole, "materials")) counter.material(material);
  counter.remark("animations not applied", array_of(whole, "animations").size());
  counter.finish();
}

}  // namespace meshgauge::api
