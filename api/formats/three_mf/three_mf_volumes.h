// Reads a slicer's metadata about the volumes of 3MF objects: which are printed, which only control the print
// (modifiers, support blockers and enforcers), and which are subtracted from others.
#pragma once

#include <cstdint>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "api/formats/file/source.h"
#include "api/formats/file/zip.h"

namespace meshgauge::api {

enum class MfVolume { printed, helper, negative };

// A range of the triangles of an object's mesh, both ends included.
struct MfTriangles {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  MfVolume volume = MfVolume::printed;
};

// Volumes by the ids of objects of the root model. Volumes not listed are printed.
struct MfVolumes {
  std::map<std::uint32_t, std::vector<MfTriangles>> of_mesh;
  std::map<std::pair<std::uint32_t, std::uint32_t>, MfVolume> of_component;  // key: object, and its component's object
};

// Reads Metadata/Slic3r_PE_model.config (PrusaSlicer and its forks) and Metadata/model_settings.config (Bambu Studio,
// OrcaSlicer) if the archive has them. Refuses, with the line, an unknown kind of volume, a range without its ends and
// more than a million volumes.
Result<MfVolumes> read_3mf_volumes(const Source& source, ZipArchive& archive);

// Returns true for the names of Cura's settings that make an object a helper: support_mesh, anti_overhang_mesh,
// infill_mesh and cutting_mesh, each also with the prefix "cura:".
bool is_mf_helper_setting(std::string_view name);

}  // namespace meshgauge::api
