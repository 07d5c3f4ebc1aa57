// The units of a comparison, from its document (openapi.yaml, "Comparison").
#pragma once

#include <algorithm>
#include <iterator>
#include <string>

#include "api/unit_plan.h"

namespace meshgauge::api {

// What is missing or is none of the names that a document has is not known: nothing is converted by it.
template <class Json>
UnitPlan unit_plan_of(const Json& document) {
  const auto named = [](const std::string& text, const auto& all, auto& out) {
    const auto found = std::find_if(std::begin(all), std::end(all), [&](auto one) { return to_string(one) == text; });
    if (found != std::end(all)) out = *found;
  };
  const auto known = [&](const char* pointer) {
    static constexpr UnitSource kSources[] = {UnitSource::file, UnitSource::declared, UnitSource::assumed};
    KnownUnit unit;
    const typename Json::json_pointer at{pointer};
    if (!document.contains(at) || !document.at(at).is_object()) return unit;
    const Json& json = document.at(at);
    const auto text = [&](const char* key) {
      return json.contains(key) && json.at(key).is_string() ? json.at(key).template get<std::string>() : std::string();
    };
    named(text("name"), kLengthUnits, unit.unit);
    named(text("source"), kSources, unit.source);
    return unit;
  };
  return {known("/meshes/a/unit"), known("/meshes/b/unit"), known("/unit")};
}

}  // namespace meshgauge::api
