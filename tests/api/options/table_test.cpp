// The table of options, and what it does for an option that is a length.
#include "api/options/table.h"

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/compare/unit_plan.h"
#include "api/options/gate.h"

using namespace meshgauge;
using api::JsonValue;
using api::LengthUnit;

namespace {

// An option of a test's own; the member is that of another one.
constexpr api::OtherOption kReach = api::length_option<&Options::uncertainty>("reach", "How far it reaches", "0.05 mm");

// A request while it is read, with this length.
struct Asking {
  explicit Asking(const JsonValue& reach) { kReach.read(reach, "/reach", draft); }

  api::Reading reading{api::kHttp};
  api::RequestLimits limits;
  api::Draft draft{reading, limits};
};

}  // namespace

TEST_CASE("table: each option has what its help and its schema need") {
  std::set<std::string_view> keys;
  for (const api::Option* option : api::all_options()) {
    CAPTURE(std::string(option->key));
    CHECK(keys.insert(option->key).second);
    CHECK(option->surfaces != 0);
    CHECK((option->read != nullptr));
    CHECK(option->help.size() >= 10);
    CHECK(option->help.size() <= 110);
    CHECK(option->help.find_first_of(".\n", option->help.size() - 1) == std::string_view::npos);
    CHECK((option->words != nullptr) == (option->kind == api::OptionKind::choice));
    if (option->kind == api::OptionKind::count) CHECK(option->range.integer);
    if (option->is_limit) CHECK((option->lengths != nullptr));
    if (option->surfaces & api::Surface::manifest) CHECK((option->surfaces & api::kEverywhere) == api::kEverywhere);
  }
}

TEST_CASE("table: a length is a number or a text with its unit, and no share") {
  for (const JsonValue& reach : {JsonValue(0.05), JsonValue("0.05"), JsonValue("0.05 mm"), JsonValue(0)}) {
    CAPTURE(reach.dump());
    const Asking asking(reach);
    CHECK(asking.reading.mistakes.empty());
    CHECK(asking.draft.options.uncertainty == (reach == 0 ? 0 : 0.05));
  }
  for (const JsonValue& reach : {JsonValue("5 %"), JsonValue(-1), JsonValue(true), JsonValue("0.05 parsec")}) {
    CAPTURE(reach.dump());
    const Asking asking(reach);
    REQUIRE(asking.reading.mistakes.size() == 1);
    CHECK(asking.reading.mistakes[0].pointer == "/reach");
    CHECK(asking.reading.mistakes[0].message.find("share") == std::string::npos);
  }
}

TEST_CASE("table: a length is in the unit of the limits, but not where they are shares") {
  Asking shares(0.05);
  shares.draft.declared = api::Reading::LimitUnit{std::nullopt, true};
  shares.draft.declared_words = "/gate/units is 'diagonal'";
  api::complete_limits(shares.draft);
  REQUIRE(shares.reading.mistakes.size() == 1);
  CHECK(shares.reading.mistakes[0].message.starts_with("/reach has no unit, and /gate/units is 'diagonal'"));

  Asking inches("0.05 in");
  inches.draft.options.max_distance = inches.reading.limit("1 mm", "/max_distance");
  api::complete_limits(inches.draft);
  REQUIRE(inches.reading.mistakes.size() == 1);
  CHECK(inches.reading.mistakes[0].pointer == "/max_distance");
}

TEST_CASE("table: a length without a gate has its unit, decides that of the result, and is written with it") {
  Asking asking("0.05 mm");
  api::complete_limits(asking.draft);
  REQUIRE(asking.reading.mistakes.empty());
  const api::ComparisonOptions& options = asking.draft.options;
  CHECK(options.units.limit == LengthUnit::millimeter);
  CHECK(kReach.write(asking.draft.request) == "0.05 mm");
  const api::FileUnit metres{api::Format::glb, LengthUnit::meter};
  const auto plan = resolve(metres, metres, options.units, first_length(options));
  REQUIRE(plan.ok());
  CHECK(plan->result.unit == LengthUnit::millimeter);

  asking.draft.options.max_distance = 1;
  CHECK(kReach.write(asking.draft.request) == 0.05);

  Asking none("0 mm");
  api::complete_limits(none.draft);
  CHECK(!none.draft.options.units.limit);
  CHECK(kReach.write(none.draft.request).is_null());
}

TEST_CASE("table: the first option that has a length is named, a 0 only where there is no other") {
  api::ComparisonOptions options;
  CHECK(api::first_length(options).empty());
  options.max_distance = 0;
  CHECK(api::first_length(options) == "max_distance");
  options.zone = {0, 1};
  CHECK(api::first_length(options) == "zone");
  options.uncertainty = 1;
  options.zone.reset();
  CHECK(api::first_length(options) == "uncertainty");
  options.uncertainty = 0;
  options.regions.emplace_back().max_distance = 1;
  CHECK(api::first_length(options) == "regions");
}

TEST_CASE("table: the shares of all options become lengths") {
  api::ComparisonOptions options;
  options.units.limit_of_diagonal = true;
  options.max_distance = 0.5;
  options.max_share_beyond = {0.25, 0.125};
  options.zone = {0.5, 0};
  options.uncertainty = 0.125;
  options.regions.emplace_back().max_distance = 0.75;
  api::resolve_shares(options, 8);
  CHECK(options.max_distance == 4);
  CHECK(options.max_share_beyond == api::ShareLimit{2, 0.125});
  CHECK(options.zone == SideOptions::Limits{4, 0});
  CHECK(options.uncertainty == 1);
  CHECK(options.regions[0].max_distance == 6);
}
