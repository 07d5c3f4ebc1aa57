#include "api/result/response.h"

#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

using namespace meshgauge;
using nlohmann::json;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

api::Comparison sample() {
  api::Comparison comparison;
  comparison.id = "0123456789abcdef0123456789abcdef";
  Directed directed;
  directed.bounds = {0.1, 0.3, Witness{Vec3(1, 2, 3), 4, Vec3(5, 6, 7), 8}};
  directed.culling = {10, 5};
  comparison.outcome.a_to_b = directed;
  comparison.outcome.lower = 0.1;
  comparison.outcome.upper = 0.3;
  comparison.outcome.diagonal_a = 2;
  comparison.outcome.simd = "neon";
  comparison.outcome.threads = 3;
  comparison.outcome.met_by = Rule::relative;
  comparison.a.bbox.extend(Vec3(0, 0, 0));
  comparison.b.bbox.extend(Vec3(0, 0, 0));
  return comparison;
}

json rendered(const api::Comparison& comparison) { return json::parse(to_json(comparison)); }

}  // namespace

TEST_CASE("response: every field has its value") {
  const json result = rendered(sample());
  CHECK(result["status"] == "converged");
  CHECK(result["direction"] == "symmetric");
  CHECK(result["distance"] == json{{"lower", 0.1}, {"upper", 0.3}});
  CHECK(result["a_to_b"]["witness"] ==
        json{{"point_a", {1, 2, 3}}, {"triangle_a", 4}, {"point_b", {5, 6, 7}}, {"triangle_b", 8}});
  CHECK(result["a_to_b"]["culling"] == json{{"triangles", 10}, {"survivors", 5}, {"rate", 0.5}});
  CHECK(result["b_to_a"].is_null());
  CHECK(result["verdict"].is_null());
  CHECK(result["gate"].is_null());
  CHECK(result["statistics"].is_null());
  CHECK(result["tolerance"]["asked"] == json{{"diagonal", 1e-6}, {"relative", 0.01}});
  CHECK(result["tolerance"]["met_by"] == "relative");
  CHECK(result["tolerance"]["reached"]["diagonal"].get<double>() == doctest::Approx(0.1));
  CHECK(result["tolerance"]["reached"]["relative"].get<double>() == doctest::Approx(2.0));
}

TEST_CASE("response: numbers round-trip") {
  api::Comparison comparison = sample();
  comparison.outcome.lower = 0x1.fffffffffffffp-3;
  comparison.outcome.upper = 0.1 + 0.2;
  const json result = rendered(comparison);
  CHECK(result["distance"]["lower"].get<double>() == 0x1.fffffffffffffp-3);
  CHECK(result["distance"]["upper"].get<double>() == 0.1 + 0.2);
}

TEST_CASE("response: nothing is infinite or NaN") {
  api::Comparison comparison = sample();
  comparison.outcome.lower = 0;
  comparison.outcome.upper = kInfinity;
  comparison.outcome.a_to_b->bounds = {0, kInfinity, std::nullopt};
  const json result = rendered(comparison);
  CHECK(result["distance"]["upper"].is_null());
  CHECK(result["a_to_b"]["upper"].is_null());
  CHECK(result["a_to_b"]["witness"].is_null());
  CHECK(result["tolerance"]["reached"] == json{{"absolute", nullptr}, {"diagonal", nullptr}, {"relative", nullptr}});
}

TEST_CASE("response: an interval of width 0 meets every rule, also at distance 0") {
  api::Comparison comparison = sample();
  comparison.outcome.lower = comparison.outcome.upper = comparison.outcome.diagonal_a = 0;
  CHECK(rendered(comparison)["tolerance"]["reached"] == json{{"absolute", 0.0}, {"diagonal", 0.0}, {"relative", 0.0}});
}

TEST_CASE("response: the gate is returned with its verdict") {
  api::Comparison comparison = sample();
  comparison.options.max_distance = 0.3;
  comparison.options.units.limit = api::LengthUnit::millimeter;
  comparison.units.result = {api::LengthUnit::millimeter, api::UnitSource::assumed};
  const json result = rendered(comparison);
  CHECK(result["verdict"] == "pass");
  CHECK(result["gate"] == json{{"max_distance", 0.3}, {"units", "mm"}});
  CHECK(result["unit"] == json{{"name", "mm"}, {"source", "assumed"}});
  comparison.options.units = {};
  comparison.options.units.limit_of_b = true;
  CHECK(rendered(comparison)["gate"]["units"] == "b");
}

TEST_CASE("response: the document has the worst verdict and the stages") {
  api::Comparison comparison = sample();
  comparison.times = {1.5, 2, 3, 10};
  comparison.options.max_distance = 0.3;
  comparison.options.expect.triangles = api::Span{1, {}};
  const json result = rendered(comparison);
  CHECK(result["verdict"] == "fail");  // the distance passes, there is no triangle
  const std::vector<api::Stage> stages = api::stages(comparison);
  REQUIRE(stages.size() == result["timings_ms"].size());
  for (const api::Stage& stage : stages) CHECK(result["timings_ms"][stage.name] == stage.ms);
}

TEST_CASE("response: the document equals what is parsed of its text") {
  api::Comparison comparison = sample();
  comparison.outcome.upper = kInfinity;
  comparison.outcome.a_to_b->bounds.upper = kInfinity;
  comparison.outcome.diagonal_a = 0;
  comparison.options.zone = SideOptions::Limits{0.1, 0.1};  // of which nothing is known
  const nlohmann::ordered_json document = api::document_of(comparison);
  CHECK(document == nlohmann::ordered_json::parse(to_json(comparison)));
  CHECK(document["distance"]["upper"].is_null());
  CHECK(document["tolerance"]["reached"]["absolute"].is_null());
  CHECK(document["criteria"].back()["upper"].is_null());
}

TEST_CASE("response: the samples per piece are reported only for n_point") {
  api::Comparison comparison = sample();
  CHECK(rendered(comparison)["engine"]["points"].is_null());
  comparison.options.strategy = Strategy::n_point;
  comparison.options.points = 31;
  CHECK(rendered(comparison)["engine"]["strategy"] == "n_point");
  CHECK(rendered(comparison)["engine"]["points"] == 31);
}

TEST_CASE("response: the engine's settings are reported as used, not as requested") {
  api::Comparison comparison = sample();
  comparison.options.simd = "auto";
  comparison.options.threads = 64;
  CHECK(rendered(comparison)["engine"]["simd"] == "neon");
  CHECK(rendered(comparison)["engine"]["threads"] == 3);
}

TEST_CASE("response: what was done to a mesh, as counts and as notes") {
  api::Comparison comparison = sample();
  const json plain = rendered(comparison)["meshes"]["a"];
  CHECK(plain["format"] == "obj");
  CHECK(plain["format_mismatch"].is_null());
  CHECK(plain["unit"] == json{{"name", nullptr}, {"source", "unknown"}});
  CHECK(plain["notes"] == json::array());

  comparison.a.format = api::Format::three_mf;
  comparison.a.degenerate = 1;
  comparison.a.notes.welded_vertices = 2;
  comparison.a.notes.gzip = true;
  comparison.a.notes.polygons = {3, 2, 1, 0, 0.25};
  comparison.a.notes.skipped_primitives = 4;
  comparison.a.notes.unused_objects = 5;
  comparison.units.a = {api::LengthUnit::foot, api::UnitSource::file};
  comparison.a.notes.media_type_says = api::Format::glb;
  const json mesh = rendered(comparison)["meshes"]["a"];
  CHECK(mesh["format"] == "3mf");
  CHECK(mesh["format_mismatch"] == json{{"file_name", nullptr}, {"media_type", "glb"}});
  CHECK(mesh["unit"] == json{{"name", "ft"}, {"source", "file"}});
  CHECK(mesh["gzip"] == true);
  CHECK(mesh["degenerate"] == 1);
  CHECK(mesh["welded_vertices"] == 2);
  CHECK(mesh["polygons"].dump() ==
        R"({"concave":2,"count":3,"largest_deviation":0.25,"non_planar":1,"self_crossing":0})");
  CHECK(mesh["skipped_primitives"] == 4);
  CHECK(mesh["unused_objects"] == 5);
  CHECK(mesh["notes"].size() == 8);
  CHECK(rendered(comparison)["meshes"]["b"] == plain);
}

TEST_CASE("response: the stages as a Server-Timing header") {
  api::Comparison comparison = sample();
  comparison.times = {1.5, 2, 3, 10};
  CHECK(api::to_server_timing(api::stages(comparison)) ==
        "queue;dur=1.500, read_a;dur=2.000, read_b;dur=3.000, build;dur=0.000, traverse;dur=0.000, "
        "reduce;dur=0.000, certify;dur=0.000, total;dur=10.000");
}

namespace {

Distribution some_distribution() {
  Distribution found;
  found.weight = Weight::length;
  found.samples = 1000;
  found.mean = {0.1, 0.01};
  found.p99 = {0.2, 0.02};
  found.max_seen = 0.25;
  found.histogram[31] = {0.5, 0.03};
  return found;
}

}  // namespace

TEST_CASE("response: statistics say that they are sampled, how, and how well") {
  api::Comparison comparison = sample();
  comparison.outcome.statistics = Statistics{{1000, 7}, some_distribution(), std::nullopt};
  comparison.outcome.timings.statistics = 4;
  const json result = rendered(comparison);
  const json statistics = result["statistics"];
  CHECK(statistics["sampled"] == true);
  CHECK(statistics["status"] == "complete");
  CHECK(statistics["seed"] == 7);
  CHECK(statistics["b_to_a"].is_null());
  const json found = statistics["a_to_b"];
  CHECK(found["weight"] == "length");
  CHECK(found["samples"] == 1000);
  CHECK(found["mean"] == json{{"value", 0.1}, {"standard_error", 0.01}});
  CHECK(found["rms"] == json{{"value", 0.0}, {"standard_error", 0.0}});
  CHECK(found["p99"] == json{{"value", 0.2}, {"standard_error", 0.02}});
  CHECK(found["max_seen"] == 0.25);
  CHECK(found["histogram"]["high"] == 0.25);
  CHECK(found["histogram"]["shares"].size() == 32);
  CHECK(found["histogram"]["shares"][31] == 0.5);
  CHECK(found["histogram"]["standard_errors"][31] == 0.03);
  CHECK(result["timings_ms"]["statistics"] == 4.0);
  const std::string timing = api::to_server_timing(api::stages(comparison));
  CHECK(timing.find("certify;dur=0.000, statistics;dur=4.000, total") != std::string::npos);
}

TEST_CASE("response: certified areas, only where they were asked for") {
  api::Comparison comparison = sample();
  CHECK(!rendered(comparison).contains("areas"));
  AreaOptions asked;
  asked.beyond = {{0.5, std::nullopt}};
  asked.quantiles = {0.95};
  AreaBounds found;
  found.beyond = {{0.25, 0.5}};
  found.quantiles = {{1, 2}};
  found.pieces = 12;
  found.stop = AreaStop::precision_floor;
  comparison.outcome.areas = AreaOutcome{asked, found, std::nullopt};
  comparison.outcome.timings.areas = 3;
  const json result = rendered(comparison);
  CHECK(result["areas"] == json{{"certified", true},
                                {"share_tolerance", 0.001},
                                {"length_tolerance", 0.01},
                                {"a_to_b",
                                 {{"status", "precision_floor"},
                                  {"pieces", 12},
                                  {"beyond", {{{"distance", 0.5}, {"share", {{"lower", 0.25}, {"upper", 0.5}}}}}},
                                  {"quantiles", {{{"share", 0.95}, {"distance", {{"lower", 1.0}, {"upper", 2.0}}}}}},
                                  {"mean", nullptr},
                                  {"rms", nullptr}}},
                                {"b_to_a", nullptr}});
  CHECK(result["timings_ms"]["areas"] == 3.0);
}

TEST_CASE("response: the topology of both meshes, only where it was asked for") {
  api::Comparison comparison = sample();
  CHECK(!rendered(comparison)["meshes"]["a"].contains("topology"));
  comparison.options.topology = true;
  Topology open;
  open.edges = 17;
  open.open = {4, {0.5, 0, 1}};
  open.components = 2;
  open.euler_characteristic = -1;
  comparison.a.topology = open;
  const json none{{"count", 0}, {"first", nullptr}};
  CHECK(rendered(comparison)["meshes"]["a"]["topology"] == json{{"watertight", false},
                                                                {"oriented", true},
                                                                {"components", 2},
                                                                {"euler_characteristic", -1},
                                                                {"edges", 17},
                                                                {"open_edges", {{"count", 4}, {"first", {0.5, 0, 1}}}},
                                                                {"non_manifold_edges", none},
                                                                {"flipped_edges", none},
                                                                {"volume", nullptr}});
  CHECK(rendered(comparison)["meshes"]["b"]["topology"] == nullptr);  // the time was over
  comparison.a.topology->volume = Volume{1, 2};
  CHECK(rendered(comparison)["meshes"]["a"]["topology"]["volume"] == json{{"lower", 1}, {"upper", 2}});
}

TEST_CASE("response: what is expected of mesh a is repeated, only where it was asked for") {
  api::Comparison comparison = sample();
  CHECK(!rendered(comparison).contains("expect"));
  comparison.options.expect.triangles = api::Span{{}, 20};
  CHECK(rendered(comparison)["expect"] == json{{"triangles", {{"max", 20}}}});
  CHECK(rendered(comparison)["expectations"].size() == 1);
}

TEST_CASE("response: statistics without time are null, with the reason") {
  api::Comparison comparison = sample();
  comparison.outcome.statistics = Statistics{{}, std::nullopt, std::nullopt, StatisticsStatus::timeout};
  const json statistics = rendered(comparison)["statistics"];
  CHECK(statistics["status"] == "timeout");
  CHECK(statistics["a_to_b"].is_null());
  CHECK(!rendered(sample())["timings_ms"].contains("statistics"));
}
