#include "api/formats/three_mf_model.h"

#include <algorithm>

#include "api/formats/text.h"
#include "api/formats/three_mf_attributes.h"
#include "api/formats/three_mf_extensions.h"
#include "api/formats/three_mf_volumes.h"

namespace meshgauge::api {
namespace {

using Defect = std::optional<XmlDefect>;

constexpr std::size_t kMostListed = 1'000'000;

class ModelReader : public XmlHandler {
 public:
  ModelReader(const Source& source, std::size_t part, MfDocument& document)
      : source_(source), part_(part), document_(document) {}

  void declare(std::string_view prefix, std::string_view name_space) override;
  Defect start(std::string_view name, const XmlAttributes& attributes) override;
  void end() override;
  bool wants_text() const override { return helper_setting_; }
  void text(std::string_view piece) override {
    if (value_.size() < kLongestValue) value_.append(piece.substr(0, kLongestValue - value_.size()));
  }

 private:
  enum class Place { outside, model, resources, object, mesh, vertices, triangles, components, metadata, build, other };
  // The meaning of an element by its parent and its name in the core namespace.
  struct Rule {
    Place parent;
    std::string_view name;
    Place place;
    Defect (ModelReader::*read)(const XmlAttributes&);
  };
  static const Rule kRules[];

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
  MfPrefixes prefixes_;  // prefixes of the root element
  MfObject* object_ = nullptr;
  bool helper_setting_ = false;  // true: inside such a setting, whose text is kept in value_
  std::string value_;
  static constexpr std::size_t kLongestValue = 16;
};

const ModelReader::Rule ModelReader::kRules[] = {
    {Place::triangles, "triangle", Place::other, &ModelReader::triangle},  // frequent elements first
    {Place::vertices, "vertex", Place::other, &ModelReader::vertex},
    {Place::outside, "model", Place::model, &ModelReader::model},
    {Place::model, "resources", Place::resources, nullptr},
    {Place::model, "build", Place::build, nullptr},
    {Place::resources, "object", Place::object, &ModelReader::object},
    {Place::object, "mesh", Place::mesh, &ModelReader::mesh},
    {Place::object, "components", Place::components, &ModelReader::components},
    {Place::mesh, "vertices", Place::vertices, nullptr},
    {Place::mesh, "triangles", Place::triangles, nullptr},
    {Place::components, "component", Place::other, &ModelReader::component},
    {Place::build, "item", Place::other, &ModelReader::item},
    {Place::object, "metadatagroup", Place::metadata, nullptr},
    {Place::metadata, "metadata", Place::other, &ModelReader::metadata},
};

void ModelReader::declare(std::string_view prefix, std::string_view name_space) {
  if (places_.back() == Place::outside) prefixes_.insert_or_assign(std::string(prefix), std::string(name_space));
}

Defect ModelReader::start(std::string_view name, const XmlAttributes& attributes) {
  const Place parent = places_.back();
  for (const Rule& rule : kRules) {
    if (rule.parent != parent || !is_mf_core(name, rule.name)) continue;
    places_.push_back(rule.place);
    return rule.read == nullptr ? std::nullopt : (this->*rule.read)(attributes);
  }
  places_.push_back(Place::other);
  if (parent == Place::outside) {
    return XmlDefect{ErrorCode::unsupported_format,
                     "the root element '" + printable(name, 100) + "' is not the model of 3MF's core namespace"};
  }
  // Elements of the standard's extensions in an object or a mesh are geometry, such as beams, or replace it.
  return parent == Place::object || parent == Place::mesh ? refuse_mf_geometry(name) : std::nullopt;
}

Defect ModelReader::model(const XmlAttributes& attributes) {
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
    if (name[0] != 'v' || name[1] < '1' || name[1] > '3' || name[2] != '\0') continue;
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
  MfPlacement placement{part_, static_cast<std::uint32_t>(id), std::nullopt};
  if (const char* path = attributes.find(kMfPathAttribute)) {
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
  const char* const printable = attributes.find("printable");  // written by slicers
  document_.build.back().printed = printable == nullptr || printable != std::string_view("0");
  return std::nullopt;
}

// Reads Cura's settings of an object.
Defect ModelReader::metadata(const XmlAttributes& attributes) {
  const char* const name = attributes.find("name");
  helper_setting_ = name != nullptr && is_mf_helper_setting(name);
  value_.clear();
  return std::nullopt;
}

void ModelReader::end() {
  if (helper_setting_ && same_word(value_, "true")) object_->steers = true;
  helper_setting_ = false;
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

std::string_view part_name(std::string_view path) {
  while (path.starts_with('/')) path.remove_prefix(1);
  return path;
}

}  // namespace meshgauge::api
