#include "check/manifest/region_setting.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/formats/text.h"
#include "api/refused.h"
#include "api/region_json.h"
#include "check/manifest/quantities.h"

namespace meshgauge::check {
namespace {

using Kind = YamlNode::Kind;

// A list of regions as JSON, with what is no part of a region's place left out.
nlohmann::json json_of(const YamlNode& node) {
  if (node.kind == Kind::none) return nullptr;
  if (node.kind == Kind::quoted) return node.text;
  nlohmann::json json = node.kind == Kind::list  ? nlohmann::json::array()
                        : node.kind == Kind::map ? nlohmann::json::object()
                                                 : nlohmann::json(node.text);
  if (node.kind == Kind::word) {
    double number = 0;
    const char* end = node.text.data() + node.text.size();
    const bool is_number = !node.text.empty() && !api::is_letter(node.text.front()) &&
                           api::parse_number(node.text.data(), end, number) == end;
    if (!is_number) return json;
    const bool is_whole = number == std::trunc(number) && std::abs(number) < 0x1p53;  // is shown as written: 5, not 5.0
    return is_whole ? nlohmann::json(static_cast<std::int64_t>(number)) : nlohmann::json(number);
  }
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (node.kind == Kind::list) {
      json.push_back(json_of(node.items[i]));
    } else {
      json[node.keys[i].text] = json_of(node.items[i]);
    }
  }
  return json;
}

const YamlNode* member_of(const YamlNode& map, std::string_view key) {
  if (map.kind != Kind::map) return nullptr;
  const auto found = std::ranges::find(map.keys, key, &Written::text);
  return found == map.keys.end() ? nullptr : &map.items[static_cast<std::size_t>(found - map.keys.begin())];
}

// The place that a pointer such as "regions/0/box/min" names, or the last on the way that there is.
Place place_of(const YamlNode& list, std::string_view pointer) {
  const YamlNode* node = &list;
  for (std::size_t at = pointer.find('/'); at != std::string_view::npos;) {
    pointer.remove_prefix(at + 1);
    at = pointer.find('/');
    const std::string_view key = pointer.substr(0, at);
    const YamlNode* next = member_of(*node, key);
    double index = 0;
    const char* end = key.data() + key.size();
    if (node->kind == Kind::list && api::parse_number(key.data(), end, index) == end && index >= 0 &&
        index < static_cast<double>(node->items.size()))
      next = &node->items[static_cast<std::size_t>(index)];
    if (!next) break;
    node = next;
  }
  return node->place;
}

std::vector<RegionLimit> read_list(const Setting& setting, Mistakes& mistakes) {
  const YamlNode& list = setting.value;
  nlohmann::json json = json_of(list);
  std::vector<RegionLimit> all(json.is_array() ? json.size() : 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const YamlNode* limit = member_of(list.items[i], "max_distance");
    if (!limit) continue;
    json[i].erase("max_distance");
    const auto parsed = parse_limit(limit->text);
    if (!limit->is_text() || !parsed) {
      mistakes.add(limit->place,
                   "max_distance of a region " +
                       (limit->is_text() ? parsed.error().message : "must be a number, not " + shown(*limit)));
      continue;
    }
    all[i].limit = *parsed;
  }
  auto regions = api::read_regions(json, std::string(setting.key));
  if (!regions) {
    const Error& error = regions.error();
    mistakes.add(place_of(list, error.where), error.message);
    return {};
  }
  for (std::size_t i = 0; i < all.size(); ++i) all[i].region = std::move((*regions)[i]);
  return all;
}

}  // namespace

void read_regions(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  draft.beside = setting.value.place;
  draft.gate.regions = read_list(setting, mistakes);
}

Result<std::vector<RegionLimit>> parse_regions(std::string_view text) {
  Mistakes mistakes;
  const auto tree = parse_yaml(text, mistakes);
  std::vector<RegionLimit> regions;
  if (tree) regions = read_list({"regions", *tree}, mistakes);
  const auto found = std::move(mistakes).sorted();
  if (!found.empty()) return refused(found.front().message);
  return regions;
}

}  // namespace meshgauge::check
