// A request while it is read: what the readers of api/options/ fill in.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/options/request.h"

namespace meshgauge::api {

// A request while it is read.
struct Draft {
  Reading& reading;
  const RequestLimits& limits;
  Request request{};
  bool tolerance_given = false;
  bool in_gate = false;                          // the limits stand in `gate`
  std::optional<Reading::LimitUnit> declared{};  // gate.units, but kUnitOfB
  std::string declared_words{};                  // "/gate/units is 'mm'"
  bool unit_of_b = false;
  std::optional<bool> narrow{};
  std::string limits_at{};  // of the first member that is about limits; empty: there is none
  std::string uncertainty_at{}, points_at{}, timeout_at{};
  std::string sides_at{};  // of the first member that asks for the sides of mesh b; empty: there is none

  ComparisonOptions& options = request.options;
};

using OptionReader = void (*)(const JsonValue& value, const std::string& at, Draft& draft);

inline Reading::Member member(std::string_view key, OptionReader read, Draft& draft) {
  return {key, [read, &draft](const JsonValue& value, const std::string& at) { read(value, at, draft); }};
}

// Reads an object of limits (limit_options() of table.h), with the unit of their numbers.
void read_gate(const JsonValue& value, const std::string& at, Draft& draft);

// Reads a unit of length; nullopt: a mistake.
std::optional<LengthUnit> read_unit(const JsonValue& value, const std::string& at, Reading& reading);

// Sets the unit of the limits, then refuses limits that do not fit each other. Call it when all members are read.
void complete_limits(Draft& draft);

}  // namespace meshgauge::api
