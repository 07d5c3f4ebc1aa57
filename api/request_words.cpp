#include "api/request_words.h"

#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/formats/text.h"
#include "api/json_filter.h"
#include "api/names.h"
#include "api/quantity.h"
#include "api/refused.h"
#include "api/unit_plan.h"

namespace meshgauge::api {
namespace {

using JsonValue = nlohmann::json;

class Words {
 public:
  explicit Words(JsonValue& options) : options_(options) {}

  Result<Done> resolve() {
    direction();
    const bool has_gate = is_object(options_, "gate");
    if (has_gate) {
      JsonValue& gate = options_["gate"];
      for (const char* key : {"max_distance", "uncertainty"}) member(gate, key, std::string("/gate/") + key);
      zone(gate);
      if (is_object(gate, "max_share_beyond")) {
        member(gate["max_share_beyond"], "distance", "/gate/max_share_beyond/distance");
        share(gate["max_share_beyond"]);
      }
    }
    regions();
    if (error_) return *error_;
    return has_gate ? unit() : Result<Done>(Done{});
  }

 private:
  static bool is_object(const JsonValue& json, const char* key) { return json.contains(key) && json[key].is_object(); }

  void fail(const std::string& pointer, const std::string& why) {
    if (!error_) error_ = refused(pointer + " " + why, "options", pointer);
  }

  void direction() {
    const auto found = options_.find("direction");
    if (found == options_.end() || !found->is_string()) return;
    if (const auto known = value_of(kDirectionWords, found->get_ref<const std::string&>()))
      *found = name_of(kDirections, *known);
  }

  void member(JsonValue& map, const char* key, const std::string& pointer) {
    if (map.contains(key)) length(map[key], pointer, "");
  }

  // `sign`: may stand before the number, and is kept.
  void length(JsonValue& value, const std::string& pointer, std::string_view sign) {
    if (!value.is_string()) {
      if (value.is_number() && value.get<double>() != 0) bare_ = pointer;
      return;
    }
    std::string_view text = trimmed(value.get_ref<const std::string&>());
    const bool is_signed = !sign.empty() && text.starts_with(sign);
    if (is_signed) text = trimmed(text.substr(1));
    const auto found = parse_length(text, false);
    if (!found && text.ends_with('%'))
      return fail(pointer,
                  "must be a length here: `meshgauge check` takes a share of the diagonal, as " + shown(value));
    if (!found) return fail(pointer, found.error().message);
    if (found->unit && unit_ && *unit_ != *found->unit)
      fail(pointer, "is in " + std::string(to_string(*found->unit)) + ", and another limit is in " +
                        std::string(to_string(*unit_)) + ": a gate is measured in one unit, write both in the same");
    if (found->unit) unit_ = found->unit;
    if (!found->unit && found->number != 0) bare_ = pointer;
    value = is_signed && sign == "-" ? 0 - found->number : found->number;
  }

  void zone(JsonValue& gate) {
    if (!gate.contains("zone") || !gate["zone"].is_array() || gate["zone"].size() != 2) return;
    length(gate["zone"][0], "/gate/zone/0", "-");
    length(gate["zone"][1], "/gate/zone/1", "+");
  }

  void share(JsonValue& limit) {
    if (!limit.contains("share") || !limit["share"].is_string()) return;
    const auto found = parse_share(limit["share"].get_ref<const std::string&>());
    if (!found) return fail("/gate/max_share_beyond/share", found.error().message);
    limit["share"] = *found;
  }

  void regions() {
    if (!options_.contains("regions") || !options_["regions"].is_array()) return;
    JsonValue& all = options_["regions"];
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all[i].is_object()) member(all[i], "max_distance", "/regions/" + std::to_string(i) + "/max_distance");
    }
  }

  Result<Done> unit() {
    if (!unit_) return Done{};
    JsonValue& gate = options_["gate"];
    const std::string name(to_string(*unit_));
    const auto given = gate.find("units");
    if (given == gate.end()) {
      if (!bare_.empty()) fail(bare_, "has no unit, and another limit is in " + name + ": write both in the same unit");
      gate["units"] = name;
    } else if (!given->is_string() || parse_unit(given->get_ref<const std::string&>()) != unit_) {
      fail("/gate/units", "is " + shown(*given) + ", and a limit is in " + name + ": write both in the same unit");
    }
    if (error_) return *error_;
    return Done{};
  }

  JsonValue& options_;
  std::optional<LengthUnit> unit_;
  std::string bare_;  // a limit that is a number without a unit
  std::optional<Error> error_;
};

}  // namespace

Result<Done> resolve_words(JsonValue& options) {
  if (!options.is_object()) return Done{};
  return Words(options).resolve();
}

}  // namespace meshgauge::api
