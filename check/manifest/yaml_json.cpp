#include "check/manifest/yaml_json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "api/base/json_filter.h"
#include "api/base/text.h"

namespace meshgauge::check {
namespace {

using Kind = YamlNode::Kind;

std::optional<double> number_of(const YamlNode& node) {
  if (node.kind != Kind::word || node.text.empty()) return std::nullopt;
  double number = 0;
  const char* end = node.text.data() + node.text.size();
  if (api::is_letter(node.text.front()) || api::parse_number(node.text.data(), end, number) != end) return std::nullopt;
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

nlohmann::json json_of_word(const YamlNode& node) {
  if (const auto number = number_of(node)) {
    const bool is_whole = *number == std::trunc(*number) && std::abs(*number) < 0x1p53;  // 5, not 5.0, in messages
    return is_whole ? nlohmann::json(static_cast<std::int64_t>(*number)) : nlohmann::json(*number);
  }
  if (node.text == "true" || node.text == "false") return node.text == "true";
  return node.text;
}

const YamlNode* element(const YamlNode& list, std::string_view index) {
  double number = 0;
  const char* end = index.data() + index.size();
  if (list.kind != Kind::list || api::parse_number(index.data(), end, number) != end) return nullptr;
  return number >= 0 && number < static_cast<double>(list.items.size()) ? &list.items[static_cast<std::size_t>(number)]
                                                                        : nullptr;
}

}  // namespace

constinit const api::Surface kManifest{api::Surface::manifest,
                                       api::dotted,
                                       "key",
                                       "a map",
                                       "a list",
                                       "empty",
                                       "the candidate",
                                       "the baseline",
                                       "candidate_to_baseline",
                                       "baseline_to_candidate",
                                       true};

nlohmann::json json_of(const YamlNode& node) {
  if (node.kind == Kind::word) return json_of_word(node);
  if (node.kind == Kind::quoted) return node.text;
  if (node.kind == Kind::none) return nullptr;
  nlohmann::json json = node.kind == Kind::map ? nlohmann::json::object() : nlohmann::json::array();
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (node.kind == Kind::list) {
      json.push_back(json_of(node.items[i]));
    } else {
      json[node.keys[i].text] = json_of(node.items[i]);
    }
  }
  return json;
}

const YamlNode* find(const YamlNode& map, std::string_view key) {
  if (map.kind != Kind::map) return nullptr;
  const auto found = std::ranges::find(map.keys, key, &Written::text);
  return found == map.keys.end() ? nullptr : &map.items[static_cast<std::size_t>(found - map.keys.begin())];
}

Place place_of(const YamlNode& tree, std::string_view pointer, bool of_key) {
  const YamlNode* node = &tree;
  while (!pointer.empty()) {
    pointer.remove_prefix(1);
    const std::string_view part = pointer.substr(0, pointer.find('/'));
    pointer.remove_prefix(part.size());
    const YamlNode* next = node->kind == Kind::list ? element(*node, part) : find(*node, part);
    if (!next) break;
    if (pointer.empty() && of_key && node->kind == Kind::map)
      return node->keys[static_cast<std::size_t>(next - node->items.data())].place;
    node = next;
  }
  return node->place;
}

std::string shown(const YamlNode& node) {
  if (node.kind == Kind::list) return "a list";
  if (node.kind == Kind::map) return node.keys.empty() ? "an empty map" : "a map";
  return node.kind == Kind::none ? "empty" : api::shown_text(node.text);
}

bool is_bare_value(const YamlNode& node) {
  if (node.kind != Kind::word) return false;
  return number_of(node) || api::same_word(node.text, "true") || api::same_word(node.text, "false");
}

}  // namespace meshgauge::check
