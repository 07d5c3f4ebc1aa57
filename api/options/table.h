// The table of options: a row each. From it follow the reader and the writer of a request and the flags of the command
// line; tests/surfaces/table.py writes by it the schemas, the keywords of Python and the table of docs/python.md.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/options/comparison_options.h"
#include "api/options/draft.h"
#include "api/options/quantity.h"
#include "api/options/request.h"
#include "api/options/surface.h"
#include "api/options/write_options.h"

namespace meshgauge::api {

// What stands for a value.
enum class OptionKind {
  length,  // in the unit of the limits, or with its own; 0: not asked for
  limit,   // the same, or a share of the diagonal of mesh b
  count,   // an integer of Option::range
  choice,  // one of Option::words
  toggle,  // true or false
  time,    // a number of seconds, or a text with its unit
  shape    // what has a schema of its own
};

using OptionWords = std::vector<std::string_view>;
using OptionLengths = std::vector<double*>;

struct Option {
  std::string_view key{};
  OptionKind kind = OptionKind::shape;
  unsigned surfaces = 0;  // of Surface::Bit: where it is offered
  bool is_limit = false;  // its lengths are what distances may not exceed
  // One line without full stop, for help and schemas. {a} and {b}: the meshes, as the surface calls them.
  std::string_view help{};
  std::string_view usual{};    // the default, as in a manifest; empty: it has none
  std::string_view example{};  // as in a manifest; empty: it has none
  Range range{};               // of a count
  OptionWords (*words)() = nullptr;
  OptionReader read = nullptr;
  // Returns those that are set of its lengths in the unit of the limits; nullptr: it has none.
  OptionLengths (*lengths)(ComparisonOptions& options) = nullptr;
};

// A limit, or an option that goes with limits alone.
struct LimitOption : Option {
  Json (*write)(const ComparisonOptions& options) = nullptr;  // returns null: it is not set
};
std::span<const LimitOption> limit_options();

// Any other option.
struct OtherOption : Option {
  Json (*write)(const Request& request) = nullptr;  // returns null: it is as usual
};

// Returns all rows, the limits first. Options are read, written and shown in this order.
const std::vector<const Option*>& all_options();

inline constexpr unsigned kOfService = Surface::http | Surface::flags;
inline constexpr unsigned kNotInGates = kOfService | Surface::python;
inline constexpr unsigned kEverywhere = kNotInGates | Surface::manifest;

// Returns the words of a table of names.
template <const auto& names>
OptionWords words_of() {
  OptionWords words;
  for (const auto& row : names) words.push_back(row.text);
  return words;
}

// Returns the length that is this member, if it is set.
template <auto member>
OptionLengths length_at(ComparisonOptions& options) {
  double& length = options.*member;
  return length != 0 ? OptionLengths{&length} : OptionLengths{};
}

// Returns a length of a request as it is written: a number beside a gate, which has the unit, else with its unit; null
// for 0.
Json json_of_length(double length, const ComparisonOptions& options);

// Returns the row of an option that is one length, a member of the options.
template <auto member>
constexpr OtherOption length_option(std::string_view key, std::string_view help, std::string_view example) {
  return {{.key = key,
           .kind = OptionKind::length,
           .surfaces = kEverywhere,
           .help = help,
           .usual = "0",
           .example = example,
           .read = [](const JsonValue& value, const std::string& at,
                      Draft& draft) { draft.options.*member = draft.reading.length(value, at).value_or(0); },
           .lengths = length_at<member>},
          [](const Request& request) { return json_of_length(request.options.*member, request.options); }};
}

}  // namespace meshgauge::api
