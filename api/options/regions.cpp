#include <algorithm>
#include <array>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/utf8.h"
#include "api/formats/groups.h"
#include "api/options/gate.h"
#include "api/options/parts.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kMostBytesOfName = 64;
constexpr Range kCoordinateRange{-kMaxCoordinate, kMaxCoordinate};
constexpr Range kRadiusRange{0, kMaxCoordinate};
constexpr const char* kShapes =
    R"({"name": "bore", "box": {"min": [x, y, z], "max": [x, y, z]}}, {"name": "tip", "sphere": {"centre": [x, y, z], "radius": r}} or {"name": "lid", "group": "Lid"})";

void read_point(const JsonValue& value, const std::string& at, Reading& reading, Vec3& point) {
  int k = 0;
  const auto read = [&](const JsonValue& coordinate, const std::string& place) {
    point[k++] = reading.number(coordinate, kCoordinateRange, place).value_or(0);
  };
  reading.elements(value, 3, 3, "numbers", read, at);
}

// Refuses what is not an object with these two members.
void read_both(const JsonValue& value, const std::array<Reading::Member, 2>& both, const std::string& at,
               Reading& reading) {
  const bool is_object = reading.members(value, both, at);
  if (is_object && !(value.contains(both[0].key) && value.contains(both[1].key)))
    reading.refuse(at, "needs " + std::string(both[0].key) + " and " + std::string(both[1].key));
}

Box read_box(const JsonValue& value, const std::string& at, Reading& reading) {
  Box box{Vec3::Zero(), Vec3::Zero()};
  const std::size_t mistakes = reading.mistakes.size();
  read_both(value,
            {{{"min", [&](const JsonValue& v, const std::string& place) { read_point(v, place, reading, box.low); }},
              {"max", [&](const JsonValue& v, const std::string& place) { read_point(v, place, reading, box.high); }}}},
            at, reading);
  for (int k = 0; k < 3 && reading.mistakes.size() == mistakes; ++k) {
    if (box.low[k] > box.high[k])
      reading.refuse(at + "/min/" + std::to_string(k), "is above that of max: the box is empty");
  }
  return box;
}

Sphere read_sphere(const JsonValue& value, const std::string& at, Reading& reading) {
  Sphere sphere;
  read_both(
      value,
      {{{"centre", [&](const JsonValue& v, const std::string& place) { read_point(v, place, reading, sphere.centre); }},
        reading.number_into("radius", sphere.radius, kRadiusRange)}},
      at, reading);
  return sphere;
}

Group read_group(const JsonValue& value, const std::string& at, Reading& reading) {
  const auto name = reading.text(value, at);
  if (name && !is_group_name(*name))
    reading.refuse(at, "must be a text of 1 to " + std::to_string(kMostBytesOfGroup) +
                           " bytes on one line, without hidden characters, not " + shown_text(*name));
  return {name.value_or(""), {}};
}

std::string read_name(const JsonValue& value, const std::string& at, Reading& reading) {
  const auto name = reading.text(value, at);
  if (name && (name->empty() || name->size() > kMostBytesOfName || find_control(*name) != std::string::npos))
    reading.refuse(at, "must be a text of 1 to " + std::to_string(kMostBytesOfName) + " bytes on one line, not " +
                           shown_text(*name));
  if (name == kRest) reading.refuse(at, "must not be 'rest': that is what lies in no region");
  return name.value_or("");
}

Region read_region(const JsonValue& value, const std::string& at, Reading& reading) {
  Region region;
  if (!value.is_object() || value.contains("box") + value.contains("sphere") + value.contains("group") != 1) {
    reading.refuse(at, std::string("must be ") + kShapes + (value.is_object() ? "" : ", not " + reading.shown(value)));
    return region;
  }
  const Reading::Member members[] = {
      {"name", [&](const JsonValue& v, const std::string& place) { region.name = read_name(v, place, reading); }},
      {"box", [&](const JsonValue& v, const std::string& place) { region.shape = read_box(v, place, reading); }},
      {"sphere", [&](const JsonValue& v, const std::string& place) { region.shape = read_sphere(v, place, reading); }},
      {"group", [&](const JsonValue& v, const std::string& place) { region.shape = read_group(v, place, reading); }},
      reading.limit_into("max_distance", region.max_distance)};
  reading.members(value, members, at);
  if (!value.contains("name")) reading.refuse(at + "/name", "is missing");
  return region;
}

}  // namespace

std::vector<Region> read_regions(const JsonValue& value, const std::string& at, Reading& reading) {
  std::vector<Region> regions;
  const auto read = [&](const JsonValue& one, const std::string& place) {
    Region region = read_region(one, place, reading);
    const bool is_known =
        !region.name.empty() && std::ranges::find(regions, region.name, &Region::name) != regions.end();
    if (is_known) reading.refuse(place + "/name", "is that of another region: " + shown_text(region.name));
    regions.push_back(std::move(region));
  };
  reading.elements(value, 1, Region::kMost, "regions", read, at);
  return regions;
}

}  // namespace meshgauge::api
