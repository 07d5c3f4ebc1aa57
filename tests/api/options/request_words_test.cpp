// Words of a request mean what they mean in a manifest, and a request is written as it is read.
#include <string>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/options/request.h"

using namespace meshgauge;
using api::parse_options;

TEST_CASE(
    "request: limits with a unit, shares in percent and the directions of a gate mean what they mean in a manifest") {
  const auto same = [](const char* words, const char* numbers) {
    const auto one = parse_options(words), other = parse_options(numbers);
    REQUIRE_MESSAGE(one.ok(), words, ": ", one.error().message);
    REQUIRE_MESSAGE(other.ok(), numbers, ": ", other.error().message);
    CHECK(api::json_of(*one) == api::json_of(*other));
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
  same(R"({"gate": {"max_distance": "0.5 %"}})", R"({"gate": {"max_distance": 0.005, "units": "diagonal"}})");
  same(R"({"gate": {"max_distance": 1}, "timeout": "1.5 s"})", R"({"gate": {"max_distance": 1}, "timeout_ms": 1500})");
  same(R"({"timeout": 60})", R"({"timeout_ms": 60000})");
  same(R"({"units": "mm"})", R"({"units": {"candidate": "mm", "baseline": "mm"}})");
  same(R"({"units": {"a": "mm", "b": "in"}})", R"({"units": {"candidate": "mm", "baseline": "in"}})");
  same(R"({"max_distance": "2 mm"})", R"({"gate": {"max_distance": "2 mm"}, "tolerance": {"diagonal": 1e-9}})");
  same(R"({"zone": ["-0.05 mm", "0.1 mm"], "narrow": false})",
       R"({"gate": {"zone": [-0.05, 0.1], "units": "mm", "narrow": false},
           "tolerance": {"diagonal": 1e-3, "relative": 0.1}})");
  same(R"({"expect": {"volume": {"within": "1 %"}}})", R"({"expect": {"volume": {"within": 0.01}}})");
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
           {R"({"gate": {"max_distance": "0.2 mm", "uncertainty": "0.01 in"}})", "/gate/uncertainty", "in one unit"},
           {R"({"gate": {"max_distance": "0.2 mm", "uncertainty": 0.01}})", "/gate/uncertainty", "has no unit"},
           {R"({"gate": {"max_distance": "0.2 mm", "units": "b"}})", "/gate/max_distance", "write both in the same"},
           {R"({"gate": {"max_distance": "0.2 mm", "units": "m"}})", "/gate/max_distance", "write both in the same"},
           {R"({"gate": {"zone": ["0.1 mm", "0.1 mm"]}})", "/gate/zone/0", ""},
           {R"({"gate": {"max_share_beyond": {"distance": 1, "share": "0.01"}}})", "/gate/max_share_beyond/share",
            "percent"},
           {R"({"gate": {"max_share_beyond": {"distance": 1, "share": "101 %"}}})", "/gate/max_share_beyond/share",
            "0 % to 100 %"},
           {R"({"direction": "candidate"})", "/direction", "must be one of"},
           {R"({"max_distance": 1, "gate": {"max_distance": 1}})", "/gate", "in one place"},
           {R"({"uncertainty": 1})", "/uncertainty", "needs max_distance"},
           {R"({"narrow": true})", "/narrow", "needs max_distance"},
           {R"({"timeout": "60 s", "timeout_ms": 60000})", "/timeout", "write one"},
           {R"({"timeout": "4 min"})", "/timeout", "from 1 ms to 180 s"},
           {R"({"max_distanse": 1})", "/max_distanse", "did you mean 'max_distance'"},
           {R"({"units": "parsec"})", "/units", "must be a unit of length"}}) {
    CAPTURE(text);
    const auto parsed = parse_options(text);
    REQUIRE(!parsed.ok());
    const Error& error = parsed.error();
    CHECK(error.where == where);
    CHECK(error.message.find(says) != std::string::npos);
  }
}

TEST_CASE("request: all mistakes are told at once, each with its place") {
  const auto parsed = parse_options(
      R"({"max_distance": "x", "zone": 1, "threads": 0, "nonsense": 1, "expect": {"triangles": -1, "watertight": 1}})");
  REQUIRE(!parsed.ok());
  std::vector<std::string> places{parsed.error().where};
  for (const Error& other : parsed.error().others) places.push_back(other.where);
  CHECK(places == std::vector<std::string>{"/max_distance", "/zone", "/threads", "/expect/watertight",
                                           "/expect/triangles", "/nonsense"});
}

TEST_CASE("request: what is written is read as the same request, and what is left out is left to the service") {
  for (
      const char* text :
      {"{}", R"({"max_distance": "0.5 %", "uncertainty": "0.1 %", "regions": [{"name": "x", "group": "y",
              "max_distance": "1 %"}]})",
       R"({"zone": [-0.1, 0.2], "sides": {"length_tolerance": 0.5}, "units": {"a": "in"}, "narrow": false})",
       R"({"max_share_beyond": {"distance": "1 mm", "share": "1 %"}, "statistics": {"seed": 7}, "threads": 3})",
       R"({"areas": {"beyond": [0.1, 3], "quantiles": [0.5], "mean": true, "share_tolerance": 0.5}, "topology": true})",
       R"({"strategy": "n_point", "points": 31, "budget": {"work_items": 7, "memory_bytes": 2000000}, "timeout": 7})",
       R"({"gate": {"max_distance": 0.012345678901234567, "units": "b"}, "align": {"overlap": 0.5},
            "expect": {"components": 1}, "direction": "b_to_a", "statistics": true})"}) {
    CAPTURE(text);
    const auto read = parse_options(text);
    REQUIRE(read.ok());
    const auto document = api::json_of(*read);
    const auto again = parse_options(document.dump());
    REQUIRE(again.ok());
    CHECK(api::json_of(*again) == document);
    CHECK(again->options.max_distance == read->options.max_distance);
    CHECK(again->options.units == read->options.units);
    CHECK(again->options.narrow == read->options.narrow);
  }
  const auto nothing = api::json_of(*parse_options("{}"));
  for (const char* absent : {"threads", "budget", "points", "statistics", "topology", "expect", "gate", "units"})
    CHECK_FALSE(nothing.contains(absent));
}
