#include "api/formats/three_mf/three_mf_volumes.h"

#include <algorithm>
#include <optional>

#include "api/formats/three_mf/three_mf_attributes.h"
#include "api/formats/three_mf/xml.h"

namespace meshgauge::api {
namespace {

using Defect = std::optional<XmlDefect>;

constexpr const char* kFiles[] = {"Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"};
constexpr std::size_t kMostVolumes = 1'000'000;

struct VolumeKind {
  std::string_view name;
  MfVolume volume;
};
// Names by PrusaSlicer, SuperSlicer, Bambu Studio and OrcaSlicer.
constexpr VolumeKind kKinds[] = {{"ModelPart", MfVolume::printed},       {"ParameterModifier", MfVolume::helper},
                                 {"SupportEnforcer", MfVolume::helper},  {"SupportBlocker", MfVolume::helper},
                                 {"NegativeVolume", MfVolume::negative}, {"SeamPosition", MfVolume::helper},
                                 {"normal_part", MfVolume::printed},     {"modifier_part", MfVolume::helper},
                                 {"support_enforcer", MfVolume::helper}, {"support_blocker", MfVolume::helper},
                                 {"negative_part", MfVolume::negative}};

// Reads <config> <object id> <volume firstid lastid> or <part id subtype> <metadata key value>.
class VolumeReader : public XmlHandler {
 public:
  explicit VolumeReader(MfVolumes& volumes) : volumes_(volumes) {}

  Defect start(const XmlName& name, const XmlAttributes& attributes) override;
  void end() override;

 private:
  static constexpr int kObjectDepth = 2;
  static constexpr int kVolumeDepth = 3;

  Defect object(const XmlAttributes& attributes);
  Defect volume(const XmlAttributes& attributes);
  Defect metadata(const XmlAttributes& attributes);
  Defect set_kind(std::string_view name);

  MfVolumes& volumes_;
  int depth_ = 0;
  std::size_t count_ = 0;
  std::uint32_t object_ = 0;
  bool in_object_ = false;
  bool in_volume_ = false;
  bool has_range_ = false;
  std::int64_t id_ = -1;  // negative: none
  MfTriangles range_;     // its kind applies to the component as well
};

Defect VolumeReader::start(const XmlName& element, const XmlAttributes& attributes) {
  const std::string_view name = element.space.empty() ? element.local : std::string_view();
  ++depth_;
  if (depth_ == kObjectDepth && name == "object") return object(attributes);
  if (!in_object_) return std::nullopt;
  if (depth_ == kVolumeDepth && (name == "volume" || name == "part")) return volume(attributes);
  if (depth_ == kVolumeDepth + 1 && in_volume_ && name == "metadata") return metadata(attributes);
  return std::nullopt;
}

Defect VolumeReader::object(const XmlAttributes& attributes) {
  std::int64_t id = 0;
  in_object_ = read_natural(attributes.find("id"), id) && id <= INT32_MAX;  // other ids belong to no object
  object_ = in_object_ ? static_cast<std::uint32_t>(id) : 0;
  return std::nullopt;
}

Defect VolumeReader::volume(const XmlAttributes& attributes) {
  if (++count_ > kMostVolumes) return XmlDefect{ErrorCode::too_large, "more than 1000000 volumes"};
  in_volume_ = true;
  range_ = {};
  const char* const first = attributes.find("firstid");
  const char* const last = attributes.find("lastid");
  has_range_ = first != nullptr || last != nullptr;
  std::int64_t ends[] = {0, 0};
  if (has_range_ && (!read_natural(first, ends[0]) || !read_natural(last, ends[1]) || ends[0] > ends[1])) {
    return malformed_xml("a volume without a valid range of triangles (firstid, lastid)");
  }
  range_.first = static_cast<std::uint64_t>(ends[0]);
  range_.last = static_cast<std::uint64_t>(ends[1]);
  if (!read_natural(attributes.find("id"), id_) || id_ > INT32_MAX) id_ = -1;
  const char* const kind = attributes.find("subtype");
  return kind == nullptr ? std::nullopt : set_kind(kind);
}

// Reads the volume's type, or "modifier", which older files have instead; if both are present, they agree.
Defect VolumeReader::metadata(const XmlAttributes& attributes) {
  const char* const key = attributes.find("key");
  const char* const value = attributes.find("value");
  if (key == nullptr || value == nullptr) return std::nullopt;
  if (key == std::string_view("volume_type")) return set_kind(value);
  if (key == std::string_view("modifier") && value == std::string_view("1") && range_.volume == MfVolume::printed) {
    range_.volume = MfVolume::helper;
  }
  return std::nullopt;
}

Defect VolumeReader::set_kind(std::string_view name) {
  const auto* const known = std::ranges::find(kKinds, name, &VolumeKind::name);
  if (known == std::end(kKinds)) {
    return XmlDefect{ErrorCode::unsupported_format,
                     "the kind of volume " + in_quotes(name) + " is unknown, and so is whether it is printed"};
  }
  range_.volume = known->volume;
  return std::nullopt;
}

void VolumeReader::end() {
  if (depth_ == kVolumeDepth && in_volume_) {
    in_volume_ = false;
    if (range_.volume != MfVolume::printed && has_range_) volumes_.of_mesh[object_].push_back(range_);
    if (range_.volume != MfVolume::printed && !has_range_ && id_ >= 0) {
      volumes_.of_component[{object_, static_cast<std::uint32_t>(id_)}] = range_.volume;
    }
  }
  if (depth_ == kObjectDepth) in_object_ = false;
  --depth_;
}

}  // namespace

Result<MfVolumes> read_3mf_volumes(const Source& source, ZipArchive& archive) {
  MfVolumes volumes;
  for (const char* const file : kFiles) {
    if (!archive.has(file)) continue;
    VolumeReader reader(volumes);
    if (auto ok = read_xml(source, archive, file, reader); !ok) return std::move(ok).error();
  }
  return volumes;
}

bool is_mf_helper_setting(std::string_view name) {
  constexpr std::string_view kPrefix = "cura:";
  constexpr std::string_view kSettings[] = {"support_mesh", "anti_overhang_mesh", "infill_mesh", "cutting_mesh"};
  if (name.starts_with(kPrefix)) name.remove_prefix(kPrefix.size());
  return std::ranges::find(kSettings, name) != std::end(kSettings);
}

}  // namespace meshgauge::api
