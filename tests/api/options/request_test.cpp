#include "api/options/request.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/options/write_options.h"

using namespace meshgauge;
using api::parse_options;

namespace {

Error refusal(const std::string& json, const api::RequestLimits& limits = {}) {
  const auto parsed = parse_options(json, limits);
  REQUIRE_MESSAGE(!parsed.ok(), json);
  CHECK(parsed.error().part == "options");
  return parsed.error();
}

}  // namespace

TEST_CASE("request: an empty document gives the defaults") {
  const auto parsed = parse_options("{}");
  REQUIRE(parsed.ok());
  CHECK(parsed->options.direction == Direction::symmetric);
  CHECK(parsed->options.strategy == Strategy::automatic);
  CHECK(parsed->options.tolerance.relative == 0.01);
  CHECK(parsed->options.tolerance.diagonal == 1e-6);
  CHECK(!parsed->options.tolerance.absolute);
  CHECK(!parsed->options.max_distance);
  CHECK(parsed->timeout.count() == 30'000);
  CHECK(parsed->options.threads == 1);
  CHECK(parsed->options.simd == "auto");
}

TEST_CASE("request: every field arrives") {
  const auto parsed = parse_options(R"({"direction": "b_to_a", "tolerance": {"absolute": 0.25, "diagonal": 0.5,
      "relative": 1e-3}, "gate": {"max_distance": 2, "units": "millimetres"}, "strategy": "n_point", "points": 31,
      "units": {"a": "in", "b": "m"}, "timeout_ms": 12345, "threads": 7, "budget": {"work_items": 1000, "memory_bytes": 2097152}})");
  REQUIRE(parsed.ok());
  CHECK(parsed->options.direction == Direction::b_to_a);
  CHECK(parsed->options.tolerance.absolute == 0.25);
  CHECK(parsed->options.tolerance.diagonal == 0.5);
  CHECK(parsed->options.tolerance.relative == 1e-3);
  CHECK(parsed->options.max_distance == 2.0);
  CHECK(parsed->options.units ==
        api::AskedUnits{api::LengthUnit::inch, api::LengthUnit::meter, api::LengthUnit::millimeter, false});
  CHECK(parsed->options.strategy == Strategy::n_point);
  CHECK(parsed->options.points == 31);
  CHECK(parsed->timeout.count() == 12345);
  CHECK(parsed->options.threads == 7);
  CHECK(parsed->options.max_work_items == 1000);
  CHECK(parsed->options.max_memory_bytes == 2097152);
}

TEST_CASE("request: a given tolerance replaces the defaults") {
  const auto parsed = parse_options(R"({"tolerance": {"absolute": 0}})");
  REQUIRE(parsed.ok());
  CHECK(parsed->options.tolerance.absolute == 0.0);
  CHECK(!parsed->options.tolerance.diagonal);
  CHECK(!parsed->options.tolerance.relative);
}

TEST_CASE("request: unknown keys are refused with the known ones") {
  CHECK(refusal(R"({"tolerence": {}})").where == "/tolerence");
  CHECK(refusal(R"({"tolerence": {}})").message.find("tolerance") != std::string::npos);
  CHECK(refusal(R"({"tolerance": {"abs": 1}})").where == "/tolerance/abs");
  CHECK(refusal(R"({"gate": {"max_distance": 1, "unit": "mm"}})").where == "/gate/unit");
  CHECK(refusal(R"({"simd": "scalar"})").where == "/simd");  // the operator's choice, not the client's
}

TEST_CASE("request: duplicate keys are refused at every level") {
  CHECK(refusal(R"({"threads": 1, "threads": 2})").message.find("'threads' occurs twice") != std::string::npos);
  CHECK(refusal(R"({"gate": {"max_distance": 1, "max_distance": 2}})").message.find("twice") != std::string::npos);
}

TEST_CASE("request: shards are refused with any value, and the message says what to do") {
  for (const char* value : {"1", "2", "0", "null", R"("two")", "[]"}) {
    const Error error = refusal(R"({"threads": 2, "shards": )" + std::string(value) + "}");
    CHECK(error.where == "/shards");
    CHECK(error.message.find("leave it out") != std::string::npos);
  }
  CHECK(refusal(R"({"tolerence": {}})").message.find("shards") == std::string::npos);
}

TEST_CASE("request: wrong types are named by their place") {
  CHECK(refusal(R"([])").message.find("must be an object, not an array") != std::string::npos);
  CHECK(refusal(R"("x")").message.find("must be an object") != std::string::npos);
  CHECK(refusal(R"({"direction": 1})").where == "/direction");
  CHECK(refusal(R"({"direction": "up"})").message.find("a_to_b, b_to_a, not 'up'") != std::string::npos);
  CHECK(refusal(R"({"strategy": null})").where == "/strategy");
  CHECK(refusal(R"({"tolerance": 0.1})").where == "/tolerance");
  CHECK(refusal(R"({"tolerance": {}})").where == "/tolerance");
  CHECK(refusal(R"({"tolerance": {"relative": "0.1"}})").where == "/tolerance/relative");
  CHECK(refusal(R"({"gate": {}})").where == "/gate");
  CHECK(refusal(R"({"gate": {"max_distance": 1, "units": 5}})").where == "/gate/units");
  CHECK(refusal(R"({"gate": {"max_distance": 1, "units": "parsec"}})").message ==
        "/gate/units must be a unit of length (um, mm, cm, m, in, ft), not 'parsec'");
  CHECK(refusal(R"({"units": 5})").where == "/units");
  CHECK(refusal(R"({"units": {"a": "", "b": "mm"}})").where == "/units/a");
  CHECK(refusal(R"({"units": {"c": "mm"}})").where == "/units/c");
  CHECK(refusal(R"({"timeout_ms": 1.5})").where == "/timeout_ms");
  CHECK(refusal(R"({"threads": true})").where == "/threads");
}

TEST_CASE("request: numbers out of range are refused") {
  CHECK(refusal(R"({"tolerance": {"absolute": -1e-9}})").where == "/tolerance/absolute");
  CHECK(refusal(R"({"tolerance": {"absolute": 1e999}})").where.starts_with("byte "));
  CHECK(refusal(R"({"gate": {"max_distance": -1}})").where == "/gate/max_distance");
  CHECK(refusal(R"({"timeout_ms": 0})").where == "/timeout_ms");
  CHECK(refusal(R"({"timeout_ms": 180001})").where == "/timeout_ms");
  CHECK(refusal(R"({"timeout_ms": 99999999999999999999})").where == "/timeout_ms");
  CHECK(refusal(R"({"threads": 0})").where == "/threads");
  CHECK(refusal(R"({"budget": {"work_items": 0}})").where == "/budget/work_items");
  CHECK(refusal(R"({"budget": {"memory_bytes": 1000}})").where == "/budget/memory_bytes");
  CHECK(refusal(R"({"budget": {"time": 1}})").where == "/budget/time");
  CHECK(refusal(R"({"threads": 65})").where == "/threads");
  CHECK(refusal(R"({"threads": -1})").where == "/threads");
  CHECK(refusal(R"({"strategy": "n_point", "points": 5})").where == "/points");
  CHECK(refusal(R"({"points": 10})").message.find("n_point") != std::string::npos);
}

TEST_CASE("request: statistics as a boolean or as an object of settings") {
  CHECK(!parse_options("{}")->options.statistics);
  CHECK(!parse_options(R"({"statistics": false})")->options.statistics);
  for (const char* text : {R"({"statistics": true})", R"({"statistics": {}})"}) {
    const auto sampling = parse_options(text)->options.statistics;
    REQUIRE(sampling.has_value());
    CHECK(sampling->samples == 100'000);
    CHECK(sampling->seed == 1);
  }
  const auto chosen = parse_options(R"({"statistics": {"samples": 1000, "seed": 9007199254740991}})");
  CHECK(chosen->options.statistics->samples == 1000);
  CHECK(chosen->options.statistics->seed == 9007199254740991U);
  CHECK(refusal(R"({"statistics": null})").where == "/statistics");
  CHECK(refusal(R"({"statistics": 1})").message.find("true, false or an object") != std::string::npos);
  CHECK(refusal(R"({"statistics": {"bins": 8}})").where == "/statistics/bins");
  CHECK(refusal(R"({"statistics": {"samples": 999}})").where == "/statistics/samples");
  CHECK(refusal(R"({"statistics": {"samples": 1000001}})").where == "/statistics/samples");
  CHECK(refusal(R"({"statistics": {"samples": 2000.5}})").where == "/statistics/samples");
  CHECK(refusal(R"({"statistics": {"seed": -1}})").where == "/statistics/seed");
  CHECK(refusal(R"({"statistics": {"seed": 9007199254740992}})").where == "/statistics/seed");
}

TEST_CASE("request: questions about areas") {
  CHECK(!parse_options("{}")->options.areas);
  const auto parsed = parse_options(R"({"areas": {"beyond": [0.05, 1], "quantiles": [0.95], "mean": true,
      "share_tolerance": 0.01, "length_tolerance": 0.1}})");
  REQUIRE(parsed.ok());
  const AreaOptions asked = parsed->options.areas.value();
  REQUIRE(asked.beyond.size() == 2);
  CHECK(asked.beyond[0].distance == 0.05);
  CHECK(!asked.beyond[0].max_share);
  CHECK(asked.quantiles == std::vector<double>{0.95});
  CHECK(asked.mean);
  CHECK(asked.share_tolerance == 0.01);
  CHECK(asked.length_tolerance == 0.1);
  CHECK(parse_options(R"({"areas": {"mean": true}})")->options.areas->share_tolerance == 0.001);
  CHECK(refusal(R"({"areas": true})").where == "/areas");
  CHECK(refusal(R"({"areas": {}})").message.find("beyond, quantiles or mean") != std::string::npos);
  CHECK(refusal(R"({"areas": {"mean": false}})").where == "/areas");
  CHECK(refusal(R"({"areas": {"beyond": []}})").where == "/areas/beyond");
  CHECK(refusal(R"({"areas": {"beyond": 0.1}})").where == "/areas/beyond");
  CHECK(refusal(R"({"areas": {"beyond": [0.1, -1]}})").where == "/areas/beyond/1");
  CHECK(refusal(R"({"areas": {"beyond": [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}})").where == "/areas/beyond");
  CHECK(refusal(R"({"areas": {"quantiles": [1]}})").message.find("from 0.001 to 0.999") != std::string::npos);
  CHECK(refusal(R"({"areas": {"mean": true, "share_tolerance": 0}})").where == "/areas/share_tolerance");
  CHECK(refusal(R"({"areas": {"median": true}})").where == "/areas/median");
}

TEST_CASE("request: the topology of both meshes is asked for by true") {
  CHECK(!parse_options("{}")->options.topology);
  CHECK(parse_options(R"({"topology": true})")->options.topology);
  CHECK(!parse_options(R"({"topology": false})")->options.topology);
  CHECK(refusal(R"({"topology": 1})").message == "/topology must be true or false, not 1");
}

TEST_CASE("request: a limit of the area") {
  const auto parsed =
      parse_options(R"({"gate": {"max_share_beyond": {"distance": 0.05, "share": 0.01}, "units": "mm"}})");
  REQUIRE(parsed.ok());
  CHECK(parsed->options.max_share_beyond == api::ShareLimit{0.05, 0.01});
  CHECK(!parsed->options.max_distance);
  CHECK(!parsed->options.areas);
  CHECK(refusal(R"({"gate": {}})").message == "/gate needs max_distance, max_share_beyond or zone");
  CHECK(refusal(R"({"gate": {"units": "mm"}})").where == "/gate");
  CHECK(refusal(R"({"gate": {"max_share_beyond": 1}})").where == "/gate/max_share_beyond");
  CHECK(refusal(R"({"gate": {"max_share_beyond": {"distance": 1}}})").message.find("has no share") !=
        std::string::npos);
  for (const char* share : {"1.2", "-0.1", "120", "\"0.01\"", "null"}) {
    CAPTURE(share);
    CHECK(refusal(R"({"gate": {"max_share_beyond": {"distance": 1, "share": )" + std::string(share) + "}}}").where ==
          "/gate/max_share_beyond/share");
  }
  CHECK(refusal(R"({"gate": {"max_share_beyond": {"distance": -1, "share": 0}}})").where ==
        "/gate/max_share_beyond/distance");
  CHECK(refusal(R"({"gate": {"max_share_beyond": {"distance": 1, "share": 0, "x": 1}}})").where ==
        "/gate/max_share_beyond/x");
}

TEST_CASE("request: a zone and sides") {
  const auto parsed =
      parse_options(R"({"gate": {"zone": [-0.05, 0.1], "units": "mm"}, "sides": {"length_tolerance": 0.1}})");
  REQUIRE(parsed.ok());
  CHECK(parsed->options.zone == SideOptions::Limits{0.05, 0.1});
  CHECK(parsed->options.sides->length_tolerance == 0.1);
  CHECK(has_limit(parsed->options));
  CHECK(parse_options(R"({"sides": true})")->options.sides.has_value());
  CHECK(!parse_options(R"({"sides": false})")->options.sides);
  CHECK(parse_options(R"({"gate": {"zone": [0, 0]}})")->options.zone == SideOptions::Limits{});
  CHECK(!std::signbit(parse_options(R"({"gate": {"zone": [-0.0, 0]}})")->options.zone->inside));
  for (const char* zone : {"0.1", "[0.1]", "[-1, 1, 2]", "null", "{}"}) {
    CAPTURE(zone);
    CHECK(refusal(R"({"gate": {"zone": )" + std::string(zone) + "}}").where == "/gate/zone");
  }
  CHECK(refusal(R"({"gate": {"zone": [0.1, 0.2]}})").where == "/gate/zone/0");
  CHECK(refusal(R"({"gate": {"zone": [-0.1, -0.2]}})").where == "/gate/zone/1");
  CHECK(refusal(R"({"gate": {"zone": ["0.1", 0.2]}})").where == "/gate/zone/0");
  CHECK(refusal(R"({"gate": {"zone": [-0.1, 0.2], "uncertainty": 0.15}})").where == "/gate/uncertainty");
  CHECK(refusal(R"({"gate": {"zone": [-0.1, 0.2]}, "direction": "b_to_a"})").where == "/gate/zone");
  CHECK(refusal(R"({"direction": "b_to_a", "sides": true})").where == "/sides");
  CHECK(refusal(R"({"sides": 1})").where == "/sides");
  CHECK(refusal(R"({"sides": {"x": 1}})").where == "/sides/x");
}

TEST_CASE("request: a service may set a lower timeout") {
  const api::RequestLimits limits{std::chrono::milliseconds(100), std::chrono::milliseconds(1000)};
  CHECK(parse_options("{}", limits)->timeout.count() == 100);
  CHECK(parse_options(R"({"timeout_ms": 1000})", limits).ok());
  CHECK(refusal(R"({"timeout_ms": 1001})", limits).message.find("from 1 to 1000") != std::string::npos);
}

TEST_CASE("request: a syntax error is refused with its byte") {
  CHECK(refusal("").where.starts_with("byte "));
  CHECK(refusal("{").where.starts_with("byte "));
  CHECK(refusal("{} {}").where.starts_with("byte "));
  CHECK(refusal(R"({"threads": NaN})").where.starts_with("byte "));
  CHECK(refusal("{\"threads\": 1,}").where.starts_with("byte "));
  CHECK(refusal("{\"gate\": {\"units\": \"\xff\"}}").where.starts_with("byte "));
  CHECK(refusal(std::string("{}\0", 3)).where.starts_with("byte "));
}

TEST_CASE("request: depth and size are bounded") {
  CHECK(refusal(std::string(20'000, '[')).message.find("nested deeper than 16") != std::string::npos);
  std::string deep = "0";
  for (int i = 0; i < 17; ++i) deep = "{\"x\":" + deep + "}";
  CHECK(refusal(deep).message.find("nested deeper than 16") != std::string::npos);
  const auto large = parse_options("{" + std::string(api::kMaxOptionsBytes, ' ') + "}");
  REQUIRE(!large.ok());
  CHECK(large.error().code == ErrorCode::too_large);
}

TEST_CASE("request: a long or unprintable key is quoted shortened, on one line") {
  const Error error = refusal("{\"" + std::string(1000, 'k') + "\\n\": 1}");
  CHECK(error.message.size() < 400);
  CHECK(refusal(R"({"a\nb": 1})").message.find('\n') == std::string::npos);
}

TEST_CASE("request: the instruction set must be one of this processor") {
  CHECK(api::as_simd("auto", "--simd").value() == supported_simd().front());
  for (const std::string_view name : supported_simd()) {
    CHECK(api::as_simd(name, "--simd").value() == name);
    CHECK(api::simd_names().find(name) != std::string::npos);
  }
  for (const std::string name : {"", "abacus", "AVX2", "auto, scalar"}) {
    const auto refused = api::as_simd(name, "--simd");
    REQUIRE(!refused.ok());
    CHECK(refused.error().where == "--simd");
    CHECK(refused.error().message ==
          "--simd must be one of " + api::simd_names() + " on this processor, not '" + name + "'");
  }
}

TEST_CASE("request: ranges refuse what is not a number") {
  CHECK(!api::in_range(std::nan(""), api::kToleranceRange, "--absolute").ok());
  CHECK(!api::in_range(std::numeric_limits<double>::infinity(), api::kToleranceRange, "--absolute").ok());
  CHECK(!api::in_range(1.5, api::kThreadsRange, "--threads").ok());
  CHECK(api::in_range(64, api::kThreadsRange, "--threads").value() == 64);
}

TEST_CASE("request: regions have a shape, a name of their own and perhaps a limit") {
  const auto read = api::parse_options(
      R"({"gate": {"max_distance": 1}, "regions": [{"name": "bore", "box": {"min": [0, -1, 0], "max": [1, 2.5, 0]},
          "max_distance": 0.5}, {"name": "tip", "sphere": {"centre": [0, 0, 4], "radius": 2}},
          {"name": "lid", "group": "the lid"}]})");
  REQUIRE(read.ok());
  const auto& regions = read->options.regions;
  REQUIRE(regions.size() == 3);
  CHECK(regions[0].name == "bore");
  CHECK(regions[0].max_distance == 0.5);
  CHECK(std::get<Box>(regions[0].shape).low == Vec3(0, -1, 0));
  CHECK(std::get<Box>(regions[0].shape).high == Vec3(1, 2.5, 0));
  CHECK(std::get<Sphere>(regions[1].shape).radius == 2);
  CHECK(!regions[1].max_distance);
  CHECK(std::get<Group>(regions[2].shape) == Group{"the lid", {}});
}

TEST_CASE("request: what is expected of mesh a") {
  const auto read = api::parse_options(
      R"({"expect": {"watertight": true, "triangles": {"max": 20}, "degenerate": 0, "volume": {"min": 1, "within": 0.01}}})");
  REQUIRE(read.ok());
  const api::Expectations& expect = read->options.expect;
  CHECK(expect.watertight == true);
  CHECK(!expect.oriented);
  CHECK(expect.triangles == api::Span{std::nullopt, 20});
  CHECK(expect.degenerate == api::Span{0, 0});
  CHECK(expect.volume == api::Span{1, std::nullopt});
  CHECK(expect.volume_within == 0.01);
  CHECK(!api::parse_options("{}")->options.expect.any());
}

TEST_CASE("request: what is expected is written as it is read") {
  const auto written = [](const std::string& expect) {
    const auto read = api::parse_options("{\"expect\": " + expect + "}");
    REQUIRE(read.ok());
    return api::json_of(read->options.expect).dump();
  };
  for (
      const char* text :
      {R"({"watertight":true,"oriented":false,"triangles":{"max":20},"degenerate":0,"components":{"min":1,"max":4294967296},)"
       R"("volume":{"min":0.1,"max":2.5,"within":0.01}})",
       R"({"volume":{"within":0.01}})", R"({"triangles":{"min":7}})"}) {
    CAPTURE(text);
    CHECK(written(text) == text);
  }
  CHECK(written(R"({"triangles":{"min":7,"max":7}})") == R"({"triangles":7})");
}

TEST_CASE("request: wrong expectations are refused with their place") {
  const auto where = [](const std::string& expect) { return refusal("{\"expect\": " + expect + "}").where; };
  CHECK(where("{}") == "/expect");
  CHECK(where("true") == "/expect");
  CHECK(where(R"({"water": true})") == "/expect/water");
  CHECK(where(R"({"oriented": 1})") == "/expect/oriented");
  CHECK(where(R"({"triangles": {}})") == "/expect/triangles");
  CHECK(where(R"({"triangles": "12"})") == "/expect/triangles");
  CHECK(where(R"({"components": 1.5})") == "/expect/components");
  CHECK(where(R"({"components": {"within": 1}})") == "/expect/components/within");
  CHECK(where(R"({"degenerate": {"min": 2, "max": 1}})") == "/expect/degenerate");
  CHECK(where(R"({"volume": 5})") == "/expect/volume");
  CHECK(where(R"({"volume": {"max": -1}})") == "/expect/volume/max");
  CHECK(where(R"({"volume": {"within": "1 mm"}})") == "/expect/volume/within");
}

TEST_CASE("request: wrong regions are refused with their place") {
  const auto where = [](const std::string& regions, const std::string& more = "") {
    return refusal("{" + more + R"("regions": )" + regions + "}").where;
  };
  const std::string box = R"("box": {"min": [0, 0, 0], "max": [1, 1, 1]})";
  const auto one = [&](const std::string& members) { return "[{" + members + "}]"; };
  CHECK(where("{}") == "/regions");
  CHECK(where("[]") == "/regions");
  CHECK(where("[1]") == "/regions/0");
  CHECK(where(one(R"("name": "x")")) == "/regions/0");
  CHECK(where(one(R"("name": "x", "sphere": {"centre": [0, 0, 0], "radius": 1}, )" + box)) == "/regions/0");
  CHECK(where(one(box)) == "/regions/0/name");
  CHECK(where(one(R"("name": "", )" + box)) == "/regions/0/name");
  CHECK(where(one(R"("name": "rest", )" + box)) == "/regions/0/name");
  CHECK(where(one(R"("name": "a\nb", )" + box)) == "/regions/0/name");
  CHECK(where(one(R"("name": ")" + std::string(65, 'x') + "\", " + box)) == "/regions/0/name");
  CHECK(where(R"([{"name": "x", )" + box + R"(}, {"name": "x", )" + box + "}]") == "/regions/1/name");
  CHECK(where(one(R"("name": "x", "box": {"min": [0, 2, 0], "max": [1, 1, 1]})")) == "/regions/0/box/min/1");
  CHECK(where(one(R"("name": "x", "box": {"min": [0, 0], "max": [1, 1, 1]})")) == "/regions/0/box/min");
  CHECK(where(one(R"("name": "x", "box": {"min": [0, 0, "1"], "max": [1, 1, 1]})")) == "/regions/0/box/min/2");
  CHECK(where(one(R"("name": "x", "box": {"min": [0, 0, 1e308], "max": [1, 1, 1]})")) == "/regions/0/box/min/2");
  CHECK(where(one(R"("name": "x", "box": {"min": [0, 0, 0]})")) == "/regions/0/box");
  CHECK(where(one(R"("name": "x", "box": {"min": [0, 0, 0], "maks": [0, 0, 0]})")) == "/regions/0/box/maks");
  CHECK(where(one(R"("name": "x", "sphere": {"centre": [0, 0, 0], "radius": -1})")) == "/regions/0/sphere/radius");
  CHECK(where(one(R"("name": "x", "group": "y", )" + box)) == "/regions/0");
  CHECK(where(one(R"("name": "x", "group": 1)")) == "/regions/0/group");
  CHECK(refusal(R"({"regions": [{"name": "x", "group": 5}]})").message.ends_with("not 5: write it in quotes"));
  CHECK(where(one(R"("name": "x", "group": "")")) == "/regions/0/group");
  CHECK(where(one(R"("name": "x", "group": "a\u009b")")) == "/regions/0/group");
  CHECK(where("[{\"name\": \"y\", " + box + R"(}, {"name": "x", "group": "g"}])", R"("direction": "a_to_b", )") ==
        "/regions/1/group");
  CHECK(api::parse_options(R"({"regions": [{"name": "x", "group": "g"}], "direction": "b_to_a"})", {}).ok());
  CHECK(where(one(R"("name": "x", "group": "a\nb")")) == "/regions/0/group");
  CHECK(where(one(R"("name": "x", "group": ")" + std::string(257, 'x') + "\"")) == "/regions/0/group");
  CHECK(where(one(R"("name": "x", "layer": "y", )" + box)) == "/regions/0/layer");
  CHECK(where(one(R"("name": "x", "max_distance": -1, )" + box)) == "/regions/0/max_distance");
  CHECK(where(one(R"("name": "x", "max_distance": 1, )" + box)) == "/regions");
  CHECK(where(one(R"("name": "x", "max_distance": 0.1, )" + box),
              R"("gate": {"max_distance": 1, "uncertainty": 0.5}, )") == "/gate/uncertainty");
  std::string many = "[";
  for (int i = 0; i < 65; ++i) many += (i ? ", {" : "{") + ("\"name\": \"" + std::to_string(i) + "\", ") + box + "}";
  CHECK(where(many + "]") == "/regions");
}
