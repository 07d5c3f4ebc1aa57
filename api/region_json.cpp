#include "api/region_json.h"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "api/formats/groups.h"
#include "api/gate.h"
#include "api/json_filter.h"
#include "api/names.h"
#include "api/refused.h"
#include "api/request.h"

namespace meshgauge::api {
namespace {

using JsonValue = nlohmann::json;

constexpr std::size_t kMostBytesOfName = 64;
constexpr Range kCoordinateRange{-kMaxCoordinate, kMaxCoordinate};
constexpr Range kRadiusRange{0, kMaxCoordinate};
constexpr const char* kRegionShapes =
    R"({"name": "bore", "box": {"min": [x, y, z], "max": [x, y, z]}}, {"name": "tip", "sphere": {"centre": [x, y, z], "radius": r}} or {"name": "lid", "group": "Lid"})";

Error misplaced(const std::string& pointer, const std::string& what) {
  return refused(pointer + " " + what, "options", pointer);
}

Result<double> number_in(const JsonValue& value, const Range& range, const std::string& pointer) {
  if (!value.is_number()) return misplaced(pointer, "must be a number, not " + shown(value));
  return in_range(value.get<double>(), range, pointer);
}

Result<Vec3> read_point(const JsonValue& value, const std::string& pointer) {
  if (!value.is_array() || value.size() != 3)
    return misplaced(pointer, "must be an array of 3 numbers, not " +
                                  (value.is_array() ? "one of " + std::to_string(value.size()) : shown(value)));
  Vec3 point;
  for (int k = 0; k < 3; ++k) {
    const auto number =
        number_in(value[static_cast<std::size_t>(k)], kCoordinateRange, pointer + "/" + std::to_string(k));
    if (!number) return number.error();
    point[k] = *number;
  }
  return point;
}

// Refuses what is not an object with these two members.
Result<Done> has_both(const JsonValue& value, const std::array<const char*, 2>& keys, const std::string& pointer) {
  const std::string both = std::string(keys[0]) + " and " + keys[1];
  if (!value.is_object()) return misplaced(pointer, "must be an object of " + both + ", not " + shown(value));
  for (const auto& [key, member] : value.items()) {
    if (key != keys[0] && key != keys[1])
      return refused("unknown option " + shown_text(pointer + "/" + key) + "; known: " + keys[0] + ", " + keys[1],
                     "options", pointer + "/" + key);
  }
  return value.size() == 2 ? Result<Done>(Done{}) : misplaced(pointer, "needs " + both);
}

Result<Box> read_box(const JsonValue& value, const std::string& pointer) {
  if (auto ok = has_both(value, {"min", "max"}, pointer); !ok) return std::move(ok).error();
  const auto low = read_point(value["min"], pointer + "/min");
  if (!low) return low.error();
  const auto high = read_point(value["max"], pointer + "/max");
  if (!high) return high.error();
  return Box{*low, *high};
}

Result<Sphere> read_sphere(const JsonValue& value, const std::string& pointer) {
  if (auto ok = has_both(value, {"centre", "radius"}, pointer); !ok) return std::move(ok).error();
  const auto centre = read_point(value["centre"], pointer + "/centre");
  if (!centre) return centre.error();
  const auto radius = number_in(value["radius"], kRadiusRange, pointer + "/radius");
  if (!radius) return radius.error();
  return Sphere{*centre, *radius};
}

Error no_text(const JsonValue& value, const std::string& pointer) {
  return misplaced(pointer, "must be a text, not " + shown(value) + (value.is_number() ? ": write it in quotes" : ""));
}

Result<Done> read_member(const std::string& key, const JsonValue& value, const std::string& pointer, Region& region) {
  if (key == "name") {
    if (!value.is_string()) return no_text(value, pointer);
    region.name = value.get<std::string>();
  } else if (key == "box") {
    const auto box = read_box(value, pointer);
    if (!box) return box.error();
    region.shape = *box;
  } else if (key == "sphere") {
    const auto sphere = read_sphere(value, pointer);
    if (!sphere) return sphere.error();
    region.shape = *sphere;
  } else if (key == "group") {
    if (!value.is_string()) return no_text(value, pointer);
    region.shape = Group{value.get<std::string>(), {}};
  } else if (key == "max_distance") {
    const auto limit = number_in(value, kMaxDistanceRange, pointer);
    if (!limit) return limit.error();
    region.max_distance = *limit;
  } else {
    return refused("unknown option " + shown_text(pointer) + "; known: name, box, sphere, group, max_distance",
                   "options", pointer);
  }
  return Done{};
}

Result<Region> read_region(const JsonValue& value, const std::string& pointer) {
  if (!value.is_object() || value.contains("box") + value.contains("sphere") + value.contains("group") != 1)
    return misplaced(pointer,
                     std::string("must be ") + kRegionShapes + (value.is_object() ? "" : ", not " + shown(value)));
  Region region;
  for (const auto& [key, member] : value.items()) {
    if (auto ok = read_member(key, member, pointer + "/" + key, region); !ok) return std::move(ok).error();
  }
  return region;
}

Result<Done> check_name(const std::string& name, const std::string& pointer) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (name.empty() || name.size() > kMostBytesOfName || std::ranges::any_of(name, is_control))
    return misplaced(pointer, "must be a text of 1 to " + std::to_string(kMostBytesOfName) +
                                  " bytes on one line, not " + shown_text(name));
  if (name == kRest) return misplaced(pointer, "must not be 'rest': that is what lies in no region");
  return Done{};
}

Result<Done> check_shape(const Box& box, const std::string& pointer) {
  for (int k = 0; k < 3; ++k) {
    if (box.low[k] > box.high[k])
      return misplaced(pointer + "/box/min/" + std::to_string(k), "is above that of max: the box is empty");
  }
  return Done{};
}
Result<Done> check_shape(const Sphere&, const std::string&) { return Done{}; }
Result<Done> check_shape(const Group& group, const std::string& pointer) {
  if (is_group_name(group.name)) return Done{};
  return misplaced(pointer + "/group", "must be a text of 1 to " + std::to_string(kMostBytesOfGroup) +
                                           " bytes on one line, without hidden characters, not " +
                                           shown_text(group.name));
}

void put(const Box& box, Json& json) {
  json["box"] = {{"min", api::json_of(box.low)}, {"max", api::json_of(box.high)}};
}
void put(const Sphere& sphere, Json& json) {
  json["sphere"] = {{"centre", api::json_of(sphere.centre)}, {"radius", sphere.radius}};
}
void put(const Group& group, Json& json) { json["group"] = group.name; }

Json measured(const RegionOutcome& found, const std::optional<double>& limit, double uncertainty) {
  const auto directed = [](const std::optional<Bounds>& bounds) {
    return bounds ? api::json_of(*bounds) : Json(nullptr);
  };
  Json json{{"distance", interval(found.lower, found.upper)},
            {"status", name_of(kStops, found.stop)},
            {"empty", found.empty},
            {"precision_floor", found.precision_floor},
            {"a_to_b", directed(found.a_to_b)},
            {"b_to_a", directed(found.b_to_a)},
            {"verdict", nullptr}};
  if (limit) json["verdict"] = to_string(verdict_within(found.lower, found.upper, *limit, uncertainty));
  return json;
}

}  // namespace

Result<std::vector<Region>> read_regions(const JsonValue& value, const std::string& pointer) {
  if (!value.is_array() || value.empty() || value.size() > Region::kMost)
    return misplaced(pointer, "must be an array of 1 to " + std::to_string(Region::kMost) + " regions, not " +
                                  (value.is_array() ? "one of " + std::to_string(value.size()) : shown(value)));
  std::vector<Region> regions;
  for (std::size_t i = 0; i < value.size(); ++i) {
    auto region = read_region(value[i], pointer + "/" + std::to_string(i));
    if (!region) return region.error();
    regions.push_back(*std::move(region));
  }
  if (auto ok = check_regions(regions, pointer); !ok) return std::move(ok).error();
  return regions;
}

Result<Done> check_regions(const std::vector<Region>& regions, const std::string& pointer) {
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const std::string place = pointer + "/" + std::to_string(i);
    if (auto ok = check_name(regions[i].name, place + "/name"); !ok) return ok;
    for (std::size_t k = 0; k < i; ++k) {
      if (regions[k].name == regions[i].name)
        return misplaced(place + "/name", "is that of another region: " + shown_text(regions[i].name));
    }
    const auto check = [&](const auto& shape) { return check_shape(shape, place); };
    if (auto ok = std::visit(check, regions[i].shape); !ok) return ok;
  }
  return Done{};
}

Result<Done> check_limits_of_regions(const ComparisonOptions& options, std::string_view name) {
  const bool any = std::ranges::any_of(options.regions, [](const Region& r) { return r.max_distance.has_value(); });
  if (!any || options.max_distance) return Done{};
  return refused(std::string(name) + ": a region with a limit needs max_distance of the gate, the limit of the rest",
                 "options", std::string(name));
}

Result<Done> check_groups(const ComparisonOptions& options, const std::string& pointer) {
  const auto is_group = [](const Region& region) { return std::holds_alternative<Group>(region.shape); };
  const auto found = std::ranges::find_if(options.regions, is_group);
  if (options.direction != Direction::a_to_b || found == options.regions.end()) return Done{};
  return refused(
      "the region " + shown_text(found->name) + " is a group of mesh b: the direction must be symmetric or b_to_a",
      "options", pointer + "/" + std::to_string(found - options.regions.begin()) + "/group");
}

Json json_of(const Region& region) {
  Json json{{"name", region.name}};
  std::visit([&](const auto& shape) { put(shape, json); }, region.shape);
  if (region.max_distance) json["max_distance"] = *region.max_distance;
  return json;
}

Json regions_of(const Outcome& outcome, const ComparisonOptions& options) {
  Json all = Json::array();
  for (std::size_t i = 0; i < outcome.regions.size(); ++i) {
    Json json = i < options.regions.size() ? json_of(options.regions[i]) : Json{{"name", kRest}};
    const auto limit = limit_of_region(options, i);
    if (limit) json["max_distance"] = *limit;
    json.update(measured(outcome.regions[i], limit, options.uncertainty));
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace meshgauge::api
