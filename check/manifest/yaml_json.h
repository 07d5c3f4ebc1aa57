// A YAML tree as the JSON document of a request, and the way back from a JSON pointer to a place in the file.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "api/options/surface.h"
#include "check/manifest/mistake.h"
#include "check/manifest/yaml_tree.h"

namespace meshgauge::check {

extern const api::Surface kManifest;

// Numbers, true and false without quotes are such; a number that is not finite stays a text.
nlohmann::json json_of(const YamlNode& node);

// Returns the value of a key; null: the map has none.
const YamlNode* find(const YamlNode& map, std::string_view key);

// Returns the place of what a pointer names in the tree, or of the last on the way that there is. `of_key`: of its key.
Place place_of(const YamlNode& tree, std::string_view pointer, bool of_key = false);

// Describes a node for "must be ..., not ...": "'x'", "a list", "a map", "empty".
std::string shown(const YamlNode& node);

// Whether YAML reads the node as a number or a boolean; a text that looks like one must be quoted.
bool is_bare_value(const YamlNode& node);

}  // namespace meshgauge::check
