#include "cli/mcp/options_schema.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "api/base/text.h"
#include "api/options/table.h"
#include "check/manifest/mistake.h"
#include "check/manifest/yaml_json.h"
#include "check/manifest/yaml_tree.h"
#include "cli/mcp/tool.h"

namespace meshgauge::mcp {
namespace {

std::string pointer_in_options(std::string_view pointer) { return "/options" + std::string(pointer); }

// Returns what stands in the table as in a manifest.
Json value_of(std::string_view yaml) {
  check::Mistakes mistakes;
  const auto tree = check::parse_yaml(yaml, mistakes);
  return tree ? Json(check::json_of(*tree)) : Json();
}

std::string help_of(const api::Option& option) {
  std::string help(option.help);
  api::replace_all(help, "{a}", "mesh a");
  api::replace_all(help, "{b}", "mesh b");
  return help;
}

Json type_of(const api::Option& option) {
  switch (option.kind) {
    case api::OptionKind::length:
    case api::OptionKind::limit:
    case api::OptionKind::time:
      return {"number", "string"};
    case api::OptionKind::count:
      return "integer";
    case api::OptionKind::choice:
      return value_of(option.words().front()).is_number() ? "integer" : "string";
    case api::OptionKind::toggle:
      return "boolean";
    case api::OptionKind::shape:
      break;
  }
  return nullptr;
}

Json option_schema(const api::Option& option) {
  Json schema{{"description", help_of(option)}};
  if (Json type = type_of(option); !type.is_null()) schema["type"] = std::move(type);
  if (option.kind == api::OptionKind::count) {
    schema["minimum"] = static_cast<std::int64_t>(option.range.low);
    schema["maximum"] = static_cast<std::int64_t>(option.range.high);
  }
  if (option.kind == api::OptionKind::choice) {
    for (const std::string_view word : option.words()) schema["enum"].push_back(value_of(word));
  }
  if (!option.usual.empty()) schema["default"] = value_of(option.usual);
  if (!option.example.empty()) schema["examples"] = Json::array({value_of(option.example)});
  return schema;
}

}  // namespace

constinit const api::Surface kToolOptions{
    api::Surface::python, pointer_in_options, "option", "an object", "an array", "null", "a", "b", "a_to_b", "b_to_a"};

Json options_schema() {
  Json properties = Json::object();
  for (const api::Option* option : api::all_options()) {
    if ((option->surfaces & api::Surface::python) != 0) properties[std::string(option->key)] = option_schema(*option);
  }
  Json schema = object_schema(std::move(properties), {});
  schema["description"] =
      "Limits, alignment, units and expectations. A verdict needs max_distance, max_share_beyond, zone or expect. "
      "Lengths may have their unit: \"0.05 mm\".";
  return schema;
}

}  // namespace meshgauge::mcp
