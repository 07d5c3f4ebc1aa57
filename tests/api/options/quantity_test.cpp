#include "api/options/quantity.h"

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

using namespace meshgauge;

namespace {

Result<api::Length> parse_limit(std::string_view text) { return api::parse_length(text, true); }
Result<std::chrono::milliseconds> parse_duration(std::string_view text) {
  return api::parse_duration(text, std::chrono::minutes(3));
}

}  // namespace

TEST_CASE("quantities: a limit is a number, with a unit or without") {
  using enum api::LengthUnit;
  struct Row {
    const char* text;
    double distance;
    std::optional<api::LengthUnit> unit;
  };
  const Row rows[] = {{"0.05", 0.05, {}},
                      {"0.05 mm", 0.05, millimeter},
                      {"0.05mm", 0.05, millimeter},
                      {" 5e-2  mm ", 0.05, millimeter},
                      {"0", 0, {}},
                      {"+3 in", 3, inch},
                      {".5 m", 0.5, meter},
                      {"5.", 5, {}},
                      {"1e300 Feet", 1e300, foot},
                      {"1 \xC2\xB5m", 1, micron},
                      {"2\"", 2, inch},
                      {"7\tft", 7, foot}};
  for (const Row& row : rows) {
    CAPTURE(row.text);
    const auto limit = parse_limit(row.text);
    REQUIRE(limit.ok());
    CHECK(limit->number == row.distance);
    CHECK(limit->unit == row.unit);
    CHECK(!limit->is_share);
  }
}

TEST_CASE("quantities: a limit in percent is a share of the diagonal") {
  for (const char* text : {"0.5 %", "0.5%", " 5e-1 % "}) {
    CAPTURE(text);
    const auto limit = parse_limit(text);
    REQUIRE(limit.ok());
    CHECK(limit->number == 0.005);
    CHECK(!limit->unit);
    CHECK(limit->is_share);
  }
}

TEST_CASE("quantities: an ambiguous limit is refused") {
  const std::string texts[] = {
      "",     " ",     "mm",      "0,05",   "0,05 mm",  "1 000 mm", "1 000",  "0x10",    "1_000",          "0.05.1",
      "--1",  "- 1",   "nan",     "inf mm", "infinity", "1e999",    "-0.05",  "-1 %",    "5 % mm",         "5 mm %",
      "5 %%", "5 m2",  "5 mm mm", "5 -",    "5em",      "5 m\x01",  "5 \xFF", "5 \xC0m", "5 \xED\xA0\x80", "5e-",
      "5e",   "5 E+mm"};
  for (const std::string& text : texts) {
    CAPTURE(text);
    const auto limit = parse_limit(text);
    REQUIRE(!limit.ok());
    CHECK(limit.error().code == ErrorCode::invalid_request);
    CHECK(limit.error().message.starts_with("must "));
  }
  CHECK(parse_limit("0,05 mm").error().message.find("behind a point") != std::string::npos);
}

TEST_CASE("quantities: an unknown unit is refused with the list of known ones") {
  for (const char* text : {"0.5 percent", "0.5Percent", "5 pct", "5 ppm", "5 parsec", "5 ly", "2 units", "5 M m"}) {
    CAPTURE(text);
    const auto limit = parse_limit(text);
    REQUIRE(!limit.ok());
    if (std::string(text) == "5 M m") continue;  // two words are no word
    CHECK(
        limit.error().message.starts_with("must have a unit of length (um, mm, cm, m, in, ft) behind the number, or "
                                          "'%' for a share of the baseline's diagonal, not '"));
  }
  for (const char* text : {"5 \xE2\x80\xB0", "5 \xEF\xBC\x85", "5\xEF\xB9\xAA", "5 \xD9\xAA"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_limit(text).ok());
  }
}

TEST_CASE("quantities: a length cannot be a share") {
  const auto length = api::parse_length("0.5 in", false);
  REQUIRE(length.ok());
  CHECK(length->number == 0.5);
  CHECK(length->unit == api::LengthUnit::inch);
  CHECK_FALSE(api::parse_length("0.5 %", false).ok());
  const auto advice = [](const auto& limit) { return limit.error().message.find('%') != std::string::npos; };
  CHECK_FALSE(advice(api::parse_length("0.5 parsec", false)));
  CHECK(advice(parse_limit("0.5 parsec")));
  CHECK_FALSE(api::parse_length("-1 mm", false).ok());
}

TEST_CASE("quantities: a duration has a unit, or is in seconds") {
  struct Row {
    const char* text;
    int milliseconds;
  };
  for (const Row& row : {Row{"60 s", 60'000},
                         {"60s", 60'000},
                         {"500 ms", 500},
                         {"2 min", 120'000},
                         {"1.5", 1'500},
                         {"90", 90'000},
                         {" 0.007 s ", 7},
                         {"1.001 s", 1'001},
                         {"3 min", 180'000},
                         {"180", 180'000},
                         {"1 ms", 1},
                         {"0.6 ms", 1},
                         {"1e-3 min", 60}}) {
    CAPTURE(row.text);
    const auto duration = parse_duration(row.text);
    REQUIRE(duration.ok());
    CHECK(duration->count() == row.milliseconds);
  }
}

TEST_CASE("quantities: a malformed or too long duration is refused") {
  for (const char* text :
       {"", "s", "1 h", "1 m", "1 sec", "60 S", "1 min 30 s", "1:30", "nan", "inf", "0x1 s", "1,5 s"}) {
    CAPTURE(text);
    const auto duration = parse_duration(text);
    REQUIRE(!duration.ok());
    CHECK(duration.error().message.find("must be a time, as 60 s, 500 ms, 2 min") == 0);
  }
  for (const char* text : {"0", "0.4 ms", "-1 s", "181", "3.1 min", "180001 ms", "1e999 s", "1e300 min"}) {
    CAPTURE(text);
    const auto duration = parse_duration(text);
    REQUIRE(!duration.ok());
    CHECK(duration.error().message.find("must be from 1 ms to 180 s, not") == 0);
  }
}

TEST_CASE("quantities: a share of the area has its %") {
  CHECK(api::parse_share("1 %").value() == 0.01);
  CHECK(api::parse_share("0%").value() == 0);
  CHECK(api::parse_share(" 100 % ").value() == 1);
  for (const char* text : {"", "1", "0.01", "1 mm", "%", "1 %%", "nan %"}) {
    CAPTURE(text);
    REQUIRE(!api::parse_share(text).ok());
    CHECK(api::parse_share(text).error().message.starts_with("must be a share of the area in percent (1 %), not "));
  }
  for (const char* text : {"120 %", "-1 %", "1e9 %"}) {
    REQUIRE(!api::parse_share(text).ok());
    CHECK(api::parse_share(text).error().message.starts_with("must be from 0 % to 100 %, not "));
  }
}
