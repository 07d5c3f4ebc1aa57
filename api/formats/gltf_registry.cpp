#include "api/formats/gltf_registry.h"

#include <algorithm>
#include <iterator>
#include <span>

namespace meshgauge::api {
namespace {

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

}  // namespace

GltfExtension gltf_extension(std::string_view name) {
  const auto known = std::ranges::find(kKnown, name, &GltfExtension::name);
  if (known != std::end(kKnown)) return *known;
  if (is_in(kHarmlessFamilies, name)) return {name, none};
  return {name, is_in(kSameFamilies, name) ? same : unknown};
}

}  // namespace meshgauge::api
