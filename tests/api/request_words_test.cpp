// Words of a request mean what they mean in a manifest.
#include "api/request_words.h"

#include <string>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include "api/request.h"

using namespace meshgauge;
using api::parse_options;

TEST_CASE(
    "request: limits with a unit, shares in percent and the directions of a gate mean what they mean in a manifest") {
  const auto same = [](const char* words, const char* numbers) {
    const auto one = parse_options(words), other = parse_options(numbers);
    REQUIRE_MESSAGE(one.ok(), words, ": ", one.error().message);
    REQUIRE(other.ok());
    CHECK(one->options.max_distance == other->options.max_distance);
    CHECK(one->options.max_share_beyond == other->options.max_share_beyond);
    CHECK(one->options.zone == other->options.zone);
    CHECK(one->options.uncertainty == other->options.uncertainty);
    CHECK(one->options.units == other->options.units);
    CHECK(one->options.direction == other->options.direction);
    REQUIRE(one->options.regions.size() == other->options.regions.size());
    if (!one->options.regions.empty())
      CHECK(one->options.regions[0].max_distance == other->options.regions[0].max_distance);
  };
  same(R"({"gate": {"max_distance": "0.2 mm"}})", R"({"gate": {"max_distance": 0.2, "units": "mm"}})");
  same(R"({"gate": {"max_distance": " 0.2"}})", R"({"gate": {"max_distance": 0.2}})");
  same(R"({"gate": {"max_distance": "0.2 inches", "uncertainty": "0.01in"}})",
       R"({"gate": {"max_distance": 0.2, "uncertainty": 0.01, "units": "in"}})");
  same(R"({"gate": {"max_distance": "0.2 mm", "units": "millimetres"}})",
       R"({"gate": {"max_distance": 0.2, "units": "mm"}})");
  same(R"({"gate": {"max_distance": "0.2 mm", "uncertainty": 0.1, "units": "mm"}})",
       R"({"gate": {"max_distance": 0.2, "uncertainty": 0.1, "units": "mm"}})");
  same(R"({"gate": {"max_share_beyond": {"distance": "0.05 mm", "share": "1 %"}}})",
       R"({"gate": {"max_share_beyond": {"distance": 0.05, "share": 0.01}, "units": "mm"}})");
  same(R"({"gate": {"zone": ["-0.05 mm", "+0.1 mm"]}})", R"({"gate": {"zone": [-0.05, 0.1], "units": "mm"}})");
  same(R"({"gate": {"zone": [0, "0.1 mm"]}})", R"({"gate": {"zone": [0, 0.1], "units": "mm"}})");
  same(R"({"direction": "candidate_to_baseline"})", R"({"direction": "a_to_b"})");
  same(R"({"direction": "baseline_to_candidate"})", R"({"direction": "b_to_a"})");
  same(R"({"gate": {"max_distance": "2 mm"}, "regions": [{"name": "x", "sphere": {"centre": [0, 0, 0], "radius": 1},
           "max_distance": "1 mm"}]})",
       R"({"gate": {"max_distance": 2, "units": "mm"}, "regions": [{"name": "x",
           "sphere": {"centre": [0, 0, 0], "radius": 1}, "max_distance": 1}]})");
}

TEST_CASE("request: a text that is no quantity, or in another unit, is refused at its place") {
  for (const auto& [text, where, says] : std::vector<std::tuple<const char*, const char*, const char*>>{
           {R"({"gate": {"max_distance": "0,2 mm"}})", "/gate/max_distance", "decimals behind a point"},
           {R"({"gate": {"max_distance": "0.2 parsec"}})", "/gate/max_distance", "must have a unit of length"},
           {R"({"gate": {"max_distance": "-1 mm"}})", "/gate/max_distance", "at least 0"},
           {R"({"gate": {"max_distance": "0.5 %"}})", "/gate/max_distance", "must be a length here"},
           {R"({"gate": {"max_distance": "0.2 mm", "uncertainty": "0.01 in"}})", "/gate/uncertainty", "in one unit"},
           {R"({"gate": {"max_distance": "0.2 mm", "uncertainty": 0.01}})", "/gate/uncertainty", "has no unit"},
           {R"({"gate": {"max_distance": "0.2 mm", "units": "b"}})", "/gate/units", "write both in the same unit"},
           {R"({"gate": {"max_distance": "0.2 mm", "units": "m"}})", "/gate/units", "write both in the same unit"},
           {R"({"gate": {"zone": ["0.1 mm", "0.1 mm"]}})", "/gate/zone/0", ""},
           {R"({"gate": {"max_share_beyond": {"distance": 1, "share": "0.01"}}})", "/gate/max_share_beyond/share",
            "percent"},
           {R"({"gate": {"max_share_beyond": {"distance": 1, "share": "101 %"}}})", "/gate/max_share_beyond/share",
            "0 % to 100 %"},
           {R"({"direction": "candidate"})", "/direction", "must be one of"}}) {
    CAPTURE(text);
    const auto parsed = parse_options(text);
    REQUIRE(!parsed.ok());
    const Error& error = parsed.error();
    CHECK(error.where == where);
    CHECK(error.message.find(says) != std::string::npos);
  }
}
