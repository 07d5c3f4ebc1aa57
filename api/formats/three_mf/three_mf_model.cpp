#include "api/formats/three_mf/three_mf_model.h"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <iterator>

#include "api/base/text.h"
#include "api/formats/three_mf/three_mf_attributes.h"
#include "api/formats/three_mf/three_mf_rows.h"
#include "api/formats/three_mf/three_mf_volumes.h"
#include "api/formats/unread.h"

namespace meshgauge::api {
namespace {

using Defect = std::optional<XmlDefect>;
using MfPrefixes = std::map<std::string, std::string, std::less<>>;  // prefix -> namespace

// The namespace of the production extension, whose attribute `path` names another part.
constexpr std::string_view kMfProduction = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
constexpr std::string_view kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
// The namespaces of the extensions that are understood: read, or without effect on the surface. Others are refused if
// they matter.
constexpr std::string_view kUnderstood[] = {kCore, kMfProduction,
                                            "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
                                            "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
                                            "http://software.ultimaker.com/xml/cura/3mf/2015/10"};
// Prefixes of the standard's namespaces; others are metadata of some program.
constexpr std::string_view kStandards[] = {"http://schemas.microsoft.com/3dmanufacturing/",
                                           "http://schemas.3mf.io/3dmanufacturing/"};

// Describes an unsupported extension by a part of its namespace's name.
struct Topic {
  std::string_view part_of_name;
  std::string_view what;
};
constexpr Topic kTopics[] = {{"beamlattice", "a beam lattice"},      {"slice", "slices"},
                             {"securecontent", "encrypted content"}, {"booleanoperations", "boolean operations"},
                             {"volumetric", "volumetric content"},   {"implicit", "implicit surfaces"},
                             {"displacement", "displaced surfaces"}, {"alternatives", "alternative objects"}};

// Returns the name of a part in a path: without the leading slash of an absolute name.
std::string_view part_name(std::string_view path) {
  while (path.starts_with('/')) path.remove_prefix(1);
  return path;
}

bool is_understood(std::string_view name_space) {
  return std::ranges::find(kUnderstood, name_space) != std::end(kUnderstood);
}

bool is_standard(std::string_view name_space) {
  return std::ranges::any_of(kStandards, [&](std::string_view start) { return name_space.starts_with(start); });
}

XmlDefect unsupported(const std::string& what, std::string_view name_space) {
  std::string topic;
  for (const Topic& known : kTopics) {
    if (topic.empty() && name_space.find(known.part_of_name) != std::string_view::npos) {
      topic = " (" + std::string(known.what) + ")";
    }
  }
  return {ErrorCode::unsupported_format,
          what + " '" + printable(name_space, 100) + "'" + topic + ", which is not supported"};
}

// Returns true for the core element of the local name `local`.
bool is_mf_core(const XmlName& name, std::string_view local) { return name.is(kCore, local); }

// Returns true for any element of the core namespace.
bool is_mf_core(const XmlName& name) { return name.space == kCore; }

// Refuses by name a required extension other than production, materials and triangle sets, which are understood.
Defect check_mf_extensions(std::string_view required_prefixes, const MfPrefixes& prefixes) {
  const char* const end = required_prefixes.data() + required_prefixes.size();
  for (const char* p = skip_spaces(required_prefixes.data(), end); p != end; p = skip_spaces(p, end)) {
    const std::string_view prefix = word_at(p, end);
    p += prefix.size();
    const auto known = prefixes.find(prefix);
    if (known == prefixes.end())
      return malformed_xml("the required extension " + in_quotes(prefix) + " is not declared");
    if (!is_understood(known->second)) return unsupported("it requires the extension", known->second);
  }
  return std::nullopt;
}

// What an element or an attribute in an object, a mesh or the build may be. Understood: of an extension that is read or
// has no effect on the surface. Standard: of another extension of the standard; those put geometry there (beams,
// volumes, booleans, slices). Other: of a vendor, or with a prefix that is not declared.
enum class MfOrigin { understood, standard, other };

MfOrigin origin_of(const XmlName& name) {
  if (is_understood(name.space)) return MfOrigin::understood;
  return is_standard(name.space) ? MfOrigin::standard : MfOrigin::other;
}

// Returns the refusal of such a standard element.
XmlDefect unsupported_mf_geometry(const XmlName& element) {
  return unsupported("geometry of the extension", element.space);
}

// Refuses attributes of an element with geometry that say that the surface is elsewhere: a mesh of low resolution
// beside slices or alternatives, a path whose prefix is not declared, and attributes of 3MF itself with a prefix, which
// others may read.
Defect check_mf_attributes(const XmlAttributes& attributes) {
  constexpr std::string_view kCoreAttributes[] = {
      "unit", "requiredextensions", "type", "objectid", "transform", "printable", "v1", "v2", "v3", "x", "y", "z"};
  for (const auto& [name, value] : attributes.prefixed()) {
    const bool is_ours = name.space.empty() || name.space == kCore;
    if (is_ours && std::ranges::find(kCoreAttributes, name.local) != std::end(kCoreAttributes)) {
      return malformed_xml("the attribute " + in_quotes(name.written) + " has a prefix; 3MF writes " +
                           in_quotes(name.local) + " without one");
    }
    if (name.space.empty() && name.local == "path") {
      return malformed_xml("the attribute " + in_quotes(name.written) +
                           " names another part, but its prefix is not declared");
    }
    const bool is_resolution = name.local == "meshresolution" || name.local == "modelresolution";
    if (is_resolution && origin_of(name) == MfOrigin::standard && value != std::string_view("fullres")) {
      return XmlDefect{
          ErrorCode::unsupported_format,
          "the attribute " + in_quotes(name.written) + " is " + in_quotes(value) +
              ": the surface is in an extension that is not supported; save the object at full resolution"};
    }
  }
  return std::nullopt;
}

// Refuses an attribute that differs from one of `known` only by upper and lower case.
Defect check_mf_spelling(const XmlAttributes& attributes, std::initializer_list<std::string_view> known) {
  for (const char* const* pair = attributes.pairs(); *pair != nullptr; pair += 2) {
    for (const std::string_view name : known) {
      if (name == pair[0] || !same_word(pair[0], name)) continue;
      return malformed_xml("the attribute " + in_quotes(pair[0]) + " is unknown; 3MF spells it " + in_quotes(name));
    }
  }
  return std::nullopt;
}

constexpr std::size_t kMostListed = 1'000'000;

class ModelReader : public XmlHandler {
 public:
  ModelReader(const Source& source, std::size_t part, MfDocument& document)
      : source_(source), part_(part), document_(document) {}

  void declare(std::string_view prefix, std::string_view name_space) override;
  Defect start(const XmlName& name, const XmlAttributes& attributes) override;
  Defect undeclared(const XmlName& name) override;
  void end() override;
  bool wants_text() const override { return helper_setting_; }
  void text(std::string_view piece) override {
    if (value_.size() < kLongestValue) value_.append(piece.substr(0, kLongestValue - value_.size()));
  }
  std::size_t find_taking(std::string_view text) const override;
  bool takes() const override {
    return plain_rows_ && (places_.back() == Place::vertices || places_.back() == Place::triangles);
  }
  XmlTaken take(std::string_view text) override;

 private:
  // leaf: an element without elements inside; skipped: one that is not read, with all inside.
  enum class Place {
    outside,
    model,
    resources,
    object,
    mesh,
    vertices,
    triangles,
    components,
    metadata,
    build,
    leaf,
    skipped
  };
  // The meaning of an element by its parent and its name in the core namespace.
  struct Rule {
    Place parent;
    std::string_view name;
    Place place;
    Defect (ModelReader::*read)(const XmlAttributes&);
  };
  static const Rule kRules[];

  static bool may_hold_others(Place place);
  Defect unknown(const XmlName& name, Place parent);
  Defect unknown_core(const XmlName& name, Place parent);
  std::string inside(Place place) const;
  void count_unread(const std::string& kind);
  Defect check_attributes(const XmlAttributes& attributes, std::string_view element);

  Defect model(const XmlAttributes& attributes);
  Defect object(const XmlAttributes& attributes);
  Defect mesh(const XmlAttributes& attributes);
  Defect components(const XmlAttributes& attributes);
  Defect vertex(const XmlAttributes& attributes);
  Defect triangle(const XmlAttributes& attributes);
  Defect component(const XmlAttributes& attributes);
  Defect item(const XmlAttributes& attributes);
  Defect metadata(const XmlAttributes& attributes);

  Defect placement(const XmlAttributes& attributes, std::vector<MfPlacement>& out);
  Defect list_one_more();

  const Source& source_;
  std::size_t part_;
  MfDocument& document_;
  std::vector<Place> places_{Place::outside};
  MfPrefixes prefixes_;          // prefixes of the root element
  MfObject* object_ = nullptr;   // nullptr: outside of objects
  bool plain_rows_ = false;      // true: rows of the current vertices or triangles have no prefix
  std::string_view leaf_;        // the last leaf
  std::string skipped_;          // the last element that is not read, in one that is
  bool helper_setting_ = false;  // true: inside such a setting, whose text is kept in value_
  std::string value_;
  static constexpr std::size_t kLongestValue = 16;
};

const ModelReader::Rule ModelReader::kRules[] = {
    {Place::triangles, "triangle", Place::leaf, &ModelReader::triangle},  // frequent elements first
    {Place::vertices, "vertex", Place::leaf, &ModelReader::vertex},
    {Place::outside, "model", Place::model, &ModelReader::model},
    {Place::model, "resources", Place::resources, nullptr},
    {Place::model, "build", Place::build, nullptr},
    {Place::resources, "object", Place::object, &ModelReader::object},
    {Place::object, "mesh", Place::mesh, &ModelReader::mesh},
    {Place::object, "components", Place::components, &ModelReader::components},
    {Place::mesh, "vertices", Place::vertices, nullptr},
    {Place::mesh, "triangles", Place::triangles, nullptr},
    {Place::components, "component", Place::leaf, &ModelReader::component},
    {Place::build, "item", Place::leaf, &ModelReader::item},
    {Place::object, "metadatagroup", Place::metadata, nullptr},
    {Place::metadata, "metadata", Place::skipped, &ModelReader::metadata},
    {Place::object, "settings", Place::metadata, nullptr},  // written by Cura before 4.0
    {Place::metadata, "setting", Place::skipped, &ModelReader::metadata},
};

void ModelReader::declare(std::string_view prefix, std::string_view name_space) {
  if (places_.back() == Place::outside) prefixes_.insert_or_assign(std::string(prefix), std::string(name_space));
}

Defect ModelReader::start(const XmlName& name, const XmlAttributes& attributes) {
  const Place parent = places_.back();
  for (const Rule& rule : kRules) {
    if (rule.parent != parent || !is_mf_core(name, rule.name)) continue;
    places_.push_back(rule.place);
    if (rule.place == Place::leaf) leaf_ = rule.name;
    if (rule.place == Place::vertices || rule.place == Place::triangles) plain_rows_ = !name.has_prefix();
    if (rule.place == Place::skipped) skipped_ = rule.name;
    auto defect = rule.read == nullptr ? std::nullopt : (this->*rule.read)(attributes);
    return defect || attributes.prefixed().empty() ? defect : check_attributes(attributes, rule.name);
  }
  places_.push_back(Place::skipped);
  if (parent == Place::outside) {
    const std::string space = name.space.empty() ? "" : " of the namespace '" + printable(name.space, 100) + "'";
    return XmlDefect{ErrorCode::unsupported_format, "the root element '" + printable(name.written, 100) + "'" + space +
                                                        " is not the model of 3MF's core namespace"};
  }
  auto defect = unknown(name, parent);
  if (parent != Place::skipped) skipped_ = name.written;
  return defect;
}

std::size_t ModelReader::find_taking(std::string_view text) const {
  for (std::size_t tag = text.find('<'); tag != std::string_view::npos; tag = text.find('<', tag + 1)) {
    const std::string_view rest = text.substr(tag);
    if (rest.starts_with("<vertices") || rest.starts_with("<triangles")) return tag;
  }
  return std::string_view::npos;
}

// The rows as vertex() and triangle() read them.
XmlTaken ModelReader::take(std::string_view text) {
  if (places_.back() == Place::triangles) {
    const std::size_t before = document_.triangles.size();
    const XmlTaken taken =
        take_mf_triangles(text, source_.limits.max_triangles, object_->vertices, document_.triangles);
    object_->triangles += document_.triangles.size() - before;
    return taken;
  }
  const std::size_t before = document_.positions.size();
  const XmlTaken taken = take_mf_vertices(text, vertex_limit(source_), document_.positions);
  object_->vertices += document_.positions.size() - before;
  return taken;
}

Defect ModelReader::undeclared(const XmlName& name) {
  if (document_.undeclared.size() < MfDocument::kMostUndeclared) document_.undeclared.emplace(name.prefix());
  return std::nullopt;
}

// In an object and in the build everything is or places surface. Resources are used only by their ids: those of other
// namespaces have no effect by themselves, nor has anything else in the model.
bool ModelReader::may_hold_others(Place place) {
  return place == Place::model || place == Place::resources || place == Place::metadata || place == Place::skipped;
}

Defect ModelReader::unknown(const XmlName& name, Place parent) {
  if (is_mf_core(name)) return unknown_core(name, parent);
  if (may_hold_others(parent)) return std::nullopt;
  const MfOrigin origin = origin_of(name);
  if (origin == MfOrigin::standard) return unsupported_mf_geometry(name);
  if (origin == MfOrigin::other) count_unread("elements " + in_quotes(name.written) + " inside " + inside(parent));
  return std::nullopt;
}

Defect ModelReader::unknown_core(const XmlName& name, Place parent) {
  constexpr std::string_view kNoSurface[] = {"metadata", "metadatagroup", "settings", "setting"};
  if (std::ranges::find(kNoSurface, name.local) != std::end(kNoSurface)) return std::nullopt;
  const bool is_geometry =
      std::ranges::any_of(kRules, [&](const Rule& rule) { return same_word(name.local, rule.name); });
  if (!is_geometry && may_hold_others(parent)) return std::nullopt;
  const std::string where = "the element " + in_quotes(name.written) + " inside " + inside(parent);
  if (parent == Place::skipped) {
    return XmlDefect{ErrorCode::unsupported_format, where + ", which is not read; write it outside of that"};
  }
  std::string known;
  for (const Rule& rule : kRules) {
    const bool is_surface = std::ranges::find(kNoSurface, rule.name) == std::end(kNoSurface);
    if (rule.parent == parent && is_surface)
      known += (known.empty() ? "" : ", ") + ("'" + std::string(rule.name) + "'");
  }
  return malformed_xml(where + " is unknown; 3MF has " + (known.empty() ? "none" : known) + " there");
}

std::string ModelReader::inside(Place place) const {
  constexpr std::string_view kNames[] = {"",         "model",     "resources",  "object",        "mesh",
                                         "vertices", "triangles", "components", "metadatagroup", "build"};
  if (place == Place::leaf) return in_quotes(leaf_);
  return in_quotes(place == Place::skipped ? std::string_view(skipped_) : kNames[static_cast<std::size_t>(place)]);
}

// Only the root model's build counts. Keeps as many kinds as Unread does.
void ModelReader::count_unread(const std::string& kind) {
  if (object_ == nullptr && part_ != 0) return;
  MfUnread& unread = object_ != nullptr ? object_->unread : document_.unread;
  const bool is_full = unread.size() + 1 >= Unread::kMostKinds && !unread.contains(kind);
  ++unread[is_full ? "all other kinds" : kind];
}

// Attributes of vendors, such as supports painted on triangles, have no effect on the surface.
Defect ModelReader::check_attributes(const XmlAttributes& attributes, std::string_view element) {
  const Place place = places_.back();
  if (place == Place::resources || place == Place::skipped) return std::nullopt;
  if (auto defect = check_mf_attributes(attributes)) return defect;
  if (place == Place::model) return std::nullopt;
  for (const auto& [name, value] : attributes.prefixed()) {
    if (origin_of(name) != MfOrigin::standard || name.local.ends_with("resolution")) continue;
    count_unread("attributes " + in_quotes(name.written) + " of " + in_quotes(element));
  }
  return std::nullopt;
}

Defect ModelReader::model(const XmlAttributes& attributes) {
  if (auto defect = check_mf_spelling(attributes, {"unit", "requiredextensions"})) return defect;
  if (const char* required = attributes.find("requiredextensions")) {
    if (auto defect = check_mf_extensions(required, prefixes_)) return defect;
  }
  LengthUnit unit = LengthUnit::millimeter;
  if (auto defect = read_unit(attributes.find("unit"), unit)) return defect;
  if (part_ == 0) document_.unit = unit;
  if (unit == document_.unit) return std::nullopt;
  return malformed_xml("the unit is " + in_quotes(to_string(unit)) + ", that of the root model " +
                       in_quotes(to_string(document_.unit)));
}

Defect ModelReader::list_one_more() {
  if (++document_.listed <= kMostListed) return std::nullopt;
  return XmlDefect{ErrorCode::too_large, "more than 1000000 objects, components and items"};
}

Defect ModelReader::object(const XmlAttributes& attributes) {
  if (auto defect = check_mf_spelling(attributes, {"type"})) return defect;
  std::int64_t id = 0;
  if (!read_natural(attributes.find("id"), id) || id > INT32_MAX) return malformed_xml("an object without a valid id");
  const auto [entry, is_new] = document_.objects.try_emplace({part_, static_cast<std::uint32_t>(id)});
  if (!is_new) return malformed_xml("a second object " + std::to_string(id));
  object_ = &entry->second;
  if (const char* const name = attributes.find("name"); name && is_group_name(name)) object_->name = name;
  if (auto defect = read_object_type(attributes.find("type"), object_->printed)) return defect;
  return list_one_more();
}

Defect ModelReader::mesh(const XmlAttributes& /*attributes*/) {
  if (object_->has_mesh || !object_->components.empty())
    return malformed_xml("a second mesh, or a mesh beside components");
  object_->has_mesh = true;
  object_->first_vertex = document_.positions.size();
  object_->first_triangle = document_.triangles.size();
  return std::nullopt;
}

Defect ModelReader::components(const XmlAttributes& /*attributes*/) {
  if (object_->has_mesh) return malformed_xml("components beside a mesh");
  return std::nullopt;
}

Defect ModelReader::vertex(const XmlAttributes& attributes) {
  Vec3 position;
  unsigned seen = 0;
  for (const char* const* pair = attributes.pairs(); *pair != nullptr; pair += 2) {
    const char axis = pair[0][0];
    if (axis < 'x' || axis > 'z' || pair[0][1] != '\0') continue;
    if (auto defect = read_coordinate(pair[1], position[axis - 'x'])) return defect;
    seen |= 1U << static_cast<unsigned>(axis - 'x');
  }
  if (seen != 7) return malformed_xml("a vertex needs the attributes x, y and z");
  if (document_.positions.size() == vertex_limit(source_)) {
    return XmlDefect{ErrorCode::too_large, "more vertices than the limit of " + std::to_string(vertex_limit(source_))};
  }
  document_.positions.push_back(position);
  ++object_->vertices;
  return std::nullopt;
}

Defect ModelReader::triangle(const XmlAttributes& attributes) {
  Triangle triangle{};
  unsigned seen = 0;
  for (const char* const* pair = attributes.pairs(); *pair != nullptr; pair += 2) {
    const char* name = pair[0];
    if (name[0] != 'v' && name[0] != 'V') continue;
    if (name[0] == 'V' || name[1] < '1' || name[1] > '3' || name[2] != '\0') {
      if (!is_digit(name[1])) continue;
      return malformed_xml("the attribute " + in_quotes(name) + " of a triangle is unknown; it has v1, v2 and v3");
    }
    const auto corner = static_cast<unsigned>(name[1] - '1');
    std::int64_t index = 0;
    if (!read_natural(pair[1], index)) return malformed_xml(in_quotes(pair[1]) + " is not an index");
    if (static_cast<std::uint64_t>(index) >= object_->vertices) {
      return XmlDefect{ErrorCode::index_out_of_range, "index " + in_quotes(pair[1]) + ", but there are " +
                                                          std::to_string(object_->vertices) + " vertices"};
    }
    triangle[corner] = static_cast<std::uint32_t>(index);
    seen |= 1U << corner;
  }
  if (seen != 7) return malformed_xml("a triangle needs the attributes v1, v2 and v3");
  if (document_.triangles.size() == source_.limits.max_triangles) {
    return XmlDefect{ErrorCode::too_large,
                     "more triangles than the limit of " + std::to_string(source_.limits.max_triangles)};
  }
  document_.triangles.push_back(triangle);
  ++object_->triangles;
  return std::nullopt;
}

Defect ModelReader::placement(const XmlAttributes& attributes, std::vector<MfPlacement>& out) {
  std::int64_t id = 0;
  if (!read_natural(attributes.find("objectid"), id) || id > INT32_MAX) return malformed_xml("no valid objectid");
  if (auto defect = check_mf_spelling(attributes, {"transform", "printable"})) return defect;
  if (attributes.find("path") != nullptr) {
    return malformed_xml("the attribute 'path' without the prefix of the production extension");
  }
  MfPlacement placement{part_, static_cast<std::uint32_t>(id), std::nullopt};
  if (const char* path = attributes.find(kMfProduction, "path")) {
    if (part_ != 0) return malformed_xml("a path to another part, which only the root model may have");
    placement.part = document_.part_named(part_name(path));
  }
  if (auto defect = read_transform(attributes.find("transform"), placement.transform)) return defect;
  out.push_back(std::move(placement));
  return list_one_more();
}

Defect ModelReader::component(const XmlAttributes& attributes) { return placement(attributes, object_->components); }

// Ignores the build of any model but the root.
Defect ModelReader::item(const XmlAttributes& attributes) {
  if (part_ != 0) return std::nullopt;
  if (auto defect = placement(attributes, document_.build)) return defect;
  const char* const found = attributes.find("printable");  // written by slicers, some of which take "true" for 0
  const std::string_view printable = found != nullptr ? found : "1";
  document_.build.back().printed = printable == "1";
  if (printable == "1" || printable == "0" || printable == "false") return std::nullopt;
  return malformed_xml("the attribute 'printable' is " + in_quotes(printable) + "; write '0' or '1'");
}

// Reads Cura's settings of an object.
Defect ModelReader::metadata(const XmlAttributes& attributes) {
  const char* const key = attributes.find("key");  // of a setting
  const char* const name = key != nullptr ? key : attributes.find("name");
  helper_setting_ = name != nullptr && is_mf_helper_setting(name);
  value_.clear();
  return std::nullopt;
}

void ModelReader::end() {
  if (helper_setting_ && same_word(value_, "true")) object_->steers = true;
  helper_setting_ = false;
  if (places_.back() == Place::object) object_ = nullptr;
  places_.pop_back();
}

}  // namespace

std::size_t MfDocument::part_named(std::string_view name) {
  if (const auto known = numbers_.find(name); known != numbers_.end()) return known->second;
  numbers_.emplace(name, parts.size());
  parts.emplace_back(name);
  return parts.size() - 1;
}

Result<Done> read_3mf_model(const Source& source, ZipArchive& archive, std::size_t part, MfDocument& document) {
  const std::string name = document.parts[part];  // a copy, since `parts` grows
  ModelReader reader(source, part, document);
  return read_xml(source, archive, name, reader);
}

}  // namespace meshgauge::api
