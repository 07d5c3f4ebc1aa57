// What a slicer notes about the volumes of an object of a 3MF: which of them are printed, which only steer the print
// (modifiers, support blockers and enforcers), and which are subtracted from the others.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/formats/source.h"
#include "api/formats/zip.h"

namespace meshgauge::api {

enum class MfVolume { printed, helper, negative };

// A range of the triangles of an object's mesh; both ends belong to it.
struct MfTriangles {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  MfVolume volume = MfVolume::printed;
};

// By the ids of objects of the root model. What is not listed is printed.
struct MfVolumes {
  std::map<std::uint32_t, std::vector<MfTriangles>> of_mesh;
  std::map<std::pair<std::uint32_t, std::uint32_t>, MfVolume> of_component;  // object, and the object it is made of
};

// Reads Metadata/Slic3r_PE_model.config (PrusaSlicer and its relatives) and Metadata/model_settings.config (Bambu
// Studio, OrcaSlicer) where the archive has them. Refused with the line: a kind of volume that is not known, a range
// without its ends, and more than a million volumes.
Result<MfVolumes> read_3mf_volumes(const Source& source, ZipArchive& archive);

// True for the names of Cura's settings that make an object a helper: support_mesh, anti_overhang_mesh, infill_mesh and
// cutting_mesh, each also behind "cura:".
bool is_mf_helper_setting(std::string_view name);

}  // namespace meshgauge::api
