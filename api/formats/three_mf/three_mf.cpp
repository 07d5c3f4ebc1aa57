#include "api/formats/file/readers.h"

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "api/formats/file/source.h"
#include "api/formats/three_mf/three_mf_attributes.h"
#include "api/formats/three_mf/three_mf_model.h"
#include "api/formats/three_mf/three_mf_volumes.h"
#include "api/formats/three_mf/xml.h"

namespace meshgauge::api {
namespace {

using Transform = std::optional<AffineMap>;

constexpr int kDeepestComponent = 64;
constexpr std::size_t kMostPlaced = 1'000'000;

// Returns the name of the part that a relationship of the package names, relative to the root or absolute.
std::string part_of_target(std::string_view target) {
  std::string name;
  while (!target.empty()) {
    const std::string_view segment = target.substr(0, target.find('/'));
    target.remove_prefix(std::min(target.size(), segment.size() + 1));
    if (segment.empty() || segment == ".") continue;
    name += (name.empty() ? "" : "/") + std::string(segment);
  }
  return name;
}

// Finds the root model in the relationships of the package.
class RootFinder : public XmlHandler {
 public:
  std::optional<XmlDefect> start(const XmlName& name, const XmlAttributes& attributes) override {
    if (!name.is("http://schemas.openxmlformats.org/package/2006/relationships", "Relationship")) return std::nullopt;
    const char* type = attributes.find("Type");
    if (type == nullptr || type != std::string_view("http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel")) {
      return std::nullopt;
    }
    const char* target = attributes.find("Target");
    const char* mode = attributes.find("TargetMode");
    if (target == nullptr) return malformed_xml("a relationship without a target");
    if (mode != nullptr && mode == std::string_view("External")) {
      return XmlDefect{ErrorCode::unsupported_format, "the model " + in_quotes(target) + " is outside of the file"};
    }
    if (!root_.empty()) return malformed_xml("a second root model, " + in_quotes(target));
    root_ = part_of_target(target);
    return std::nullopt;
  }

  const std::string& root() const { return root_; }

 private:
  std::string root_;
};

Result<std::string> find_root(const Source& source, ZipArchive& archive) {
  if (!archive.has(kRelationships)) {
    return about(source.part, ErrorCode::unsupported_format,
                 "is a zip archive, not a mesh: a 3MF contains '_rels/.rels'");
  }
  RootFinder finder;
  if (auto ok = read_xml(source, archive, kRelationships, finder); !ok) return std::move(ok).error();
  if (finder.root().empty()) {
    return about(source.part, ErrorCode::unsupported_format, "is a package without a 3D model");
  }
  return finder.root();
}

Result<MfDocument> read_models(const Source& source, ZipArchive& archive, std::string_view root) {
  MfDocument document;
  document.part_named(root);
  for (std::size_t part = 0; part < document.parts.size(); ++part) {
    if (auto ok = read_3mf_model(source, archive, part, document); !ok) return std::move(ok).error();
  }
  return document;
}

Transform combined(const Transform& outer, const Transform& inner) {
  if (!outer) return inner;
  return inner ? Transform(composed(*outer, *inner)) : outer;
}

// Copies the objects that the build places into one mesh.
class Placer {
 public:
  Placer(const Source& source, const MfDocument& document, const MfVolumes& volumes)
      : source_(source), document_(document), volumes_(volumes) {
    out_.format = Format::three_mf;
    out_.notes.unit = document.unit;
  }

  Result<ReadMesh> run();

 private:
  Result<Done> place(const MfPlacement& placement, std::size_t user, const Transform& outer);
  Result<Done> copy(const MfKey& key, const MfObject& object, const Transform& to_world);
  Result<std::span<const Triangle>> printed_triangles(const MfKey& key, const MfObject& object);
  MfVolume volume_of(const MfPlacement& placement, const MfObject& object) const;
  Error fail(const MfKey& object, const std::string& what, ErrorCode code = ErrorCode::unreadable_mesh) const {
    return at(source_, printable(document_.parts[object.first], 100) + ", object " + std::to_string(object.second),
              code, what);
  }
  Error negative(const MfKey& object) const {
    return fail(object, "a negative volume, which the slicer subtracts from others; export the resulting mesh instead",
                ErrorCode::unsupported_format);
  }
  Error shows_nothing() const;
  void add_unread(const MfUnread& unread) {
    for (const auto& [kind, count] : unread) out_.unread.add(kind, count);
  }

  const Source& source_;
  const MfDocument& document_;
  const MfVolumes& volumes_;
  std::vector<MfKey> open_;  // the objects that contain the current one
  std::set<MfKey> shown_;
  std::set<MfKey> helpers_;                         // objects placed but not printed
  std::map<MfKey, std::vector<Triangle>> printed_;  // printed triangles of objects with helper volumes
  std::size_t placed_ = 0;
  GroupCollector groups_;
  ReadMesh out_;
};

Result<Done> Placer::place(const MfPlacement& placement, std::size_t user, const Transform& outer) {
  const MfKey key{placement.part, placement.object};
  const auto found = document_.objects.find(key);
  if (found == document_.objects.end()) {
    return fail(key, "does not exist, but " + printable(document_.parts[user], 100) + " places it");
  }
  if (std::ranges::find(open_, key) != open_.end()) return fail(key, "a component of itself");
  if (open_.size() == kDeepestComponent) return fail(key, "components nested deeper than 64");
  if (++placed_ > kMostPlaced) {
    return about(source_.part, ErrorCode::too_large, "places more than 1000000 objects and components");
  }
  const MfVolume volume = volume_of(placement, found->second);
  if (volume == MfVolume::negative) return negative(key);
  if (volume == MfVolume::helper) {
    helpers_.insert(key);
    ++out_.notes.helper_objects;
    return Done{};
  }
  if (shown_.insert(key).second) add_unread(found->second.unread);
  const std::size_t first = out_.mesh.triangles.size();
  const Transform to_world = combined(outer, placement.transform);
  if (auto ok = copy(key, found->second, to_world); !ok) return ok;
  open_.push_back(key);
  for (const MfPlacement& component : found->second.components) {
    if (auto ok = place(component, key.first, to_world); !ok) return ok;
  }
  open_.pop_back();
  groups_.add(found->second.name, first, out_.mesh.triangles.size());
  return Done{};
}

MfVolume Placer::volume_of(const MfPlacement& placement, const MfObject& object) const {
  if (!open_.empty() && open_.back().first == 0) {
    const auto noted = volumes_.of_component.find({open_.back().second, placement.object});
    if (noted != volumes_.of_component.end()) return noted->second;
  }
  const bool is_part = (object.printed || !object.components.empty()) && !object.steers;
  return placement.printed && is_part ? MfVolume::printed : MfVolume::helper;
}

Result<Done> Placer::copy(const MfKey& key, const MfObject& object, const Transform& to_world) {
  std::vector<Vec3>& positions = out_.mesh.positions;
  std::vector<Triangle>& triangles = out_.mesh.triangles;
  const auto printed = printed_triangles(key, object);
  if (!printed) return printed.error();
  if (printed->empty()) return Done{};
  if (printed->size() > source_.limits.max_triangles - triangles.size()) {
    return too_many(source_, "triangles", source_.limits.max_triangles);
  }
  if (object.vertices > vertex_limit(source_) - positions.size()) {
    return too_many(source_, "vertices", vertex_limit(source_));
  }
  const auto first = static_cast<std::uint32_t>(positions.size());
  reserve_more(positions, object.vertices);
  reserve_more(triangles, printed->size());
  for (std::size_t i = 0; i < object.vertices; ++i) {
    const Vec3& local = document_.positions[object.first_vertex + i];
    positions.push_back(to_world ? (*to_world)(local) : local);
  }
  for (const Triangle& local : *printed) {
    triangles.push_back({first + local[0], first + local[1], first + local[2]});
  }
  return Done{};
}

// Returns the triangles of an object without those of volumes that are not printed. Ranges may overlap. Takes time
// linear in ranges and triangles, once for all placements. Vertices used only by triangles left out remain; they are
// not part of the surface.
Result<std::span<const Triangle>> Placer::printed_triangles(const MfKey& key, const MfObject& object) {
  const auto all = std::span(document_.triangles).subspan(object.first_triangle, object.triangles);
  const auto noted = key.first == 0 ? volumes_.of_mesh.find(key.second) : volumes_.of_mesh.end();
  if (noted == volumes_.of_mesh.end()) return all;
  out_.notes.helper_objects += noted->second.size();
  if (const auto known = printed_.find(key); known != printed_.end()) return std::span<const Triangle>(known->second);
  std::vector<std::int32_t> begun_less_ended(all.size() + 1);
  for (const MfTriangles& range : noted->second) {
    if (range.last >= all.size()) return fail(key, "the slicer's metadata names a triangle that does not exist");
    if (range.volume == MfVolume::negative) return negative(key);
    ++begun_less_ended[range.first];
    --begun_less_ended[range.last + 1];
  }
  std::vector<Triangle>& printed = printed_[key];
  std::int32_t open = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if ((open += begun_less_ended[i]) == 0) printed.push_back(all[i]);
  }
  return std::span<const Triangle>(printed);
}

Error Placer::shows_nothing() const {
  if (out_.notes.helper_objects != 0) {
    return about(
        source_.part, ErrorCode::empty_mesh,
        "has no printed triangles: its build places only supports, modifiers and objects marked as not printable");
  }
  return about(source_.part, ErrorCode::empty_mesh,
               "has no triangles: its build places none of its " + std::to_string(document_.objects.size()) +
                   " objects, or only empty ones");
}

Result<ReadMesh> Placer::run() {
  add_unread(document_.unread);
  for (const MfPlacement& item : document_.build) {
    if (auto ok = place(item, 0, std::nullopt); !ok) return std::move(ok).error();
  }
  out_.groups = groups_.take();
  for (const MfKey& key : shown_) helpers_.erase(key);
  out_.notes.unused_objects = document_.objects.size() - shown_.size() - helpers_.size();
  if (out_.mesh.triangles.empty() && !document_.triangles.empty() && out_.unread.empty()) return shows_nothing();
  return std::move(out_);
}

// Returns the number of models in the archive that the root model and its parts do not name.
std::size_t unused_models(const ZipArchive& archive, const MfDocument& document) {
  std::set<std::string> used;
  for (const std::string& part : document.parts) used.insert(file_key(part));
  const std::vector<std::string> names = archive.names();
  return static_cast<std::size_t>(std::ranges::count_if(names, [&](const std::string& name) {
    return name.ends_with(".model") && !name.starts_with("__macosx/") && !used.contains(name);
  }));
}

std::string undeclared_prefixes(const MfDocument& document) {
  std::string prefixes;
  for (const std::string& prefix : document.undeclared) prefixes += (prefixes.empty() ? "" : ", ") + in_quotes(prefix);
  return document.undeclared.size() == MfDocument::kMostUndeclared ? prefixes + " and perhaps more" : prefixes;
}

void add_remarks(std::size_t renamed, const ZipArchive& archive, const MfDocument& document, ReadNotes& notes) {
  notes.add_remark("names in the archive with '\\' between folders, read as '/'", renamed);
  if (!document.undeclared.empty()) {
    notes.remarks.push_back("prefixes that are not declared, their elements and attributes ignored: " +
                            undeclared_prefixes(document));
  }
  notes.add_remark("models in the archive that the root model does not use, not read",
                   unused_models(archive, document));
}

}  // namespace

Result<ReadMesh> read_3mf(const Source& source) {
  auto archive = ZipArchive::open(source);
  if (!archive) return std::move(archive).error();
  const auto renamed = archive->join_backslashes();
  if (!renamed) return renamed.error();
  const auto root = find_root(source, *archive);
  if (!root) return root.error();
  const auto document = read_models(source, *archive, *root);
  if (!document) return document.error();
  const auto volumes = read_3mf_volumes(source, *archive);
  if (!volumes) return volumes.error();
  auto read = Placer(source, *document, *volumes).run();
  if (read) add_remarks(*renamed, *archive, *document, read->notes);
  return read;
}

}  // namespace meshgauge::api
