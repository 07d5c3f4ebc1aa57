#include "api/map/deviation_maker.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/result/criteria.h"
#include "shapes.h"

using namespace meshgauge;
using api::MapForm;
using api::Side;
using nlohmann::json;

namespace {

json directed(double lower, const json& upper, double x) {
  return {{"lower", lower},
          {"upper", upper},
          {"witness", {{"point_a", {x, 0, 0}}, {"triangle_a", 1}, {"point_b", {x, 1, 0}}, {"triangle_b", 2}}}};
}

json document() {
  return {{"gate", {{"max_distance", 0.5}, {"units", "mm"}}},
          {"unit", {{"name", "mm"}, {"source", "declared"}}},
          {"meshes", {{"a", {{"unit", {{"name", "in"}, {"source", "file"}}}}}, {"b", {{"unit", nullptr}}}}},
          {"distance", {{"lower", 2}, {"upper", 3}}},
          {"a_to_b", directed(1, 3, 10)},
          {"b_to_a", directed(2, 2.5, 20)}};
}

api::ResultFacts facts(const json& of, Side side) {
  const auto found = api::result_facts(nlohmann::ordered_json::parse(of.dump()), side);
  REQUIRE(found.ok());
  return *found;
}

// A sphere with one vertex pulled out, and one without.
struct Pair {
  Mesh bumpy = shapes::sphere(60);
  Mesh plain = shapes::sphere(60);
  std::uint32_t bump = 5000;

  Pair() { bumpy.positions[bump] *= 1.25; }
};

}  // namespace

TEST_CASE("result facts: each side has its direction, and the witness is that of the lower bound") {
  const auto a = facts(document(), Side::a);
  CHECK(a.limit->limit == 0.5);
  CHECK(a.units.result.unit == api::LengthUnit::millimeter);
  CHECK(api::factor_between(a.units.a, a.units.result) == Factor{127, 5});
  CHECK(api::factor_between(a.units.b, a.units.result).is_one());
  CHECK(a.lower == 2);
  CHECK(a.upper == 3);
  CHECK(a.direction->upper == 3);
  CHECK(a.direction->witness->on_candidate);
  CHECK(a.direction->witness->from.x() == 10);
  CHECK(a.witness->from.x() == 20);
  CHECK_FALSE(a.witness->on_candidate);
  const auto b = facts(document(), Side::b);
  CHECK(b.direction->upper == 2.5);
  CHECK(b.direction->witness->from.x() == 20);
  CHECK(b.witness->on_candidate);
  CHECK(b.witness->to_triangle == 2);
}

TEST_CASE("result facts: the limit is that of the criteria, and of one side has that side") {
  json of = document();
  of["criteria"] = json::array();
  for (const auto& [side, most] : {std::pair("inside", 0.0), std::pair("outside", 5.0)}) {
    api::Criterion criterion;
    criterion.side = side;
    criterion.limit = most;
    criterion.lower = 2, criterion.upper = 3;
    of["criteria"].push_back(json(api::json_of(criterion, "mm")));
  }
  const auto limit = facts(of, Side::a).limit;
  CHECK(limit->side == "inside");
  CHECK(limit->limit == 0);
  of["criteria"] = json::array({json{{"name", "of another version"}}});
  CHECK(facts(of, Side::a).limit->limit == 0.5);
}

TEST_CASE("result facts: a direction that was not measured has no interval") {
  json one = document();
  one["a_to_b"] = nullptr;
  one["gate"] = nullptr;
  one["distance"]["upper"] = nullptr;
  const auto a = facts(one, Side::a);
  CHECK_FALSE(a.direction.has_value());
  CHECK_FALSE(a.limit.has_value());
  CHECK(std::isinf(a.upper));
  CHECK(a.witness->from.x() == 20);
  one["b_to_a"]["upper"] = -1;
  one["b_to_a"]["witness"] = nullptr;
  CHECK_FALSE(facts(one, Side::b).direction.has_value());
  CHECK_FALSE(facts(one, Side::b).witness.has_value());
  for (const char* text : {"", "{}", "[]", R"({"gate": 1})", "null"}) {
    CHECK(api::result_facts(nlohmann::ordered_json::parse(text, nullptr, false), Side::a).error().code ==
          ErrorCode::internal);
  }
}

TEST_CASE("deviation maker: without sides the map says why, in the words of the result or its own") {
  const Mesh shown = shapes::sphere(8), sheet = shapes::grid(4), ball = shapes::closed_sphere(9);
  const Prepared candidate(shown), open(sheet), closed(ball);
  Control control;
  json of = document();
  of["sides"] = {{"refused", {{"detail", "mesh b is open: somewhere"}}}};
  const auto told = make_deviation(candidate, closed, facts(of, Side::a), {}, control);
  CHECK(told->map().no_sides == "the baseline is open: somewhere");
  CHECK(told->map().sides.empty());
  CHECK(
      make_deviation(candidate, open, facts(of, Side::b), {}, control)->map().no_sides.empty());  // were not asked for
  of["sides"]["refused"] = nullptr;                                                               // as after a time-out
  CHECK(make_deviation(candidate, open, facts(of, Side::a), {}, control)->map().no_sides ==
        "the baseline has no sides");
  const auto known = make_deviation(candidate, closed, facts(of, Side::a), {}, control);
  CHECK(known->map().no_sides.empty());
  CHECK(known->map().sides.size() == candidate.mesh().positions.size());
}

TEST_CASE("deviation maker: a decimated map has the farthest vertex and all beyond the limit") {
  const Pair pair;
  const Prepared bumpy(pair.bumpy), plain(pair.plain);
  api::ResultFacts known;
  Control control;
  api::MapOptions options;
  options.refine = true;
  options.max_triangles = 1000;
  for (const bool limited : {false, true}) {
    if (limited) known.limit = {{0.1}};
    const auto made = api::make_deviation(bumpy, plain, known, options, control);
    REQUIRE(made.ok());
    const api::DeviationMap& map = made->map();
    CHECK(map.form == MapForm::decimated);
    CHECK(map.mesh.triangles.size() <= 1000);
    CHECK(map.candidate_triangles == pair.bumpy.triangles.size());
    CHECK(map.candidate_vertices == pair.bumpy.positions.size());
    REQUIRE(map.distances.size() == map.mesh.positions.size());
    const double farthest = *std::max_element(map.distances.begin(), map.distances.end());
    CHECK(farthest == doctest::Approx(0.25).epsilon(0.01));
    CHECK(map.scale.limited == limited);
    CHECK(map.scale.top == (limited ? 0.1 : farthest));
  }
}

TEST_CASE("deviation maker: a decimated map has a small loose part that is farthest away") {
  Mesh dirty = shapes::sphere(100);
  const Mesh clean = dirty;
  const auto first = static_cast<std::uint32_t>(dirty.positions.size());
  dirty.positions.insert(dirty.positions.end(), {{1.3, 0, 0}, {1.2999, 1e-4, 0}, {1.2999, 0, 1e-4}});
  dirty.triangles.push_back({first, first + 1, first + 2});
  const Prepared candidate(dirty), baseline(clean);
  api::ResultFacts known;
  known.limit = {{0.1}};
  Control control;
  for (const std::size_t most : {20'000U, 5000U, 1000U, 1U}) {
    api::MapOptions options;
    options.max_triangles = most;
    const auto made = api::make_deviation(candidate, baseline, known, options, control);
    REQUIRE(made.ok());
    CHECK(made->map().mesh.triangles.size() <= most);
    CHECK(*std::max_element(made->map().distances.begin(), made->map().distances.end()) == doctest::Approx(0.3));
  }
}

TEST_CASE("deviation maker: refined if the triangle limit allows, else unchanged") {
  const Mesh cube = shapes::cube(), other = shapes::cube(1, {0, 0, 0.5});
  const Prepared candidate(cube), baseline(other);
  Control control;
  const auto form = [&](bool refine, std::size_t most) {
    api::MapOptions options;
    options.refine = refine;
    options.max_triangles = most;
    const auto made = api::make_deviation(candidate, baseline, {}, options, control);
    REQUIRE(made.ok());
    CHECK(made->map().mesh.triangles.size() <= std::max<std::size_t>(most, 1));
    CHECK(validate(made->map().mesh, {}, "a").ok());
    return made->map().form;
  };
  CHECK(form(false, 1'000'000) == MapForm::as_is);
  CHECK(form(true, 1'000'000) == MapForm::refined);
  CHECK(form(true, 100) == MapForm::refined);
  CHECK(form(true, 12) == MapForm::as_is);
  CHECK(form(true, 11) == MapForm::decimated);
  CHECK(form(true, 1) == MapForm::decimated);
}

TEST_CASE("deviation maker: no distance exceeds the certified bound, and an interruption ends the work") {
  const Pair pair;
  const Prepared bumpy(pair.bumpy), plain(pair.plain);
  api::ResultFacts known;
  known.direction = api::ResultDirection{0, 0.125, std::nullopt};
  Control control;
  const auto made = api::make_deviation(bumpy, plain, known, {}, control);
  REQUIRE(made.ok());
  CHECK(made->map().distances[pair.bump] == 0.125);
  control.cancel();
  CHECK(api::make_deviation(bumpy, plain, known, {}, control).error().code == ErrorCode::out_of_time);
}

TEST_CASE("deviation maker: normals are those of the triangles by area, of every form, and of no cloud") {
  const Mesh cube = shapes::cube(1e-200), other = shapes::cube(2e-200);
  const Prepared candidate(cube), baseline(other);
  Control control;
  api::MapOptions options;
  CHECK(api::make_deviation(candidate, baseline, {}, options, control)->map().normals.empty());
  options.normals = true;
  for (const std::size_t most : {std::size_t{100'000}, std::size_t{6}}) {
    options.refine = most > 12;
    options.max_triangles = most;
    const auto made = api::make_deviation(candidate, baseline, {}, options, control);
    const api::DeviationMap& map = made->map();
    CHECK(map.form == (options.refine ? MapForm::refined : MapForm::decimated));
    REQUIRE(map.normals.size() == map.mesh.positions.size());
    for (std::size_t v = 0; v < map.normals.size(); ++v) {
      CHECK(std::abs(map.normals[v].norm() - 1) < 1e-12);
      CHECK(map.normals[v].dot(map.mesh.positions[v] - Vec3::Constant(5e-201)) > 0);  // outwards
    }
  }
  const Mesh bent{{{0, 0, 0}, {3, 0, 0}, {0, 1, 0}, {0, 0, 1}, {9, 9, 9}},
                  {{0, 1, 2}, {0, 2, 3}}};  // of areas 3/2, 1/2
  const Prepared corner(bent);
  const auto made = api::make_deviation(corner, baseline, {}, {.normals = true}, control);
  CHECK((made->map().normals[0] - Vec3(1, 0, 3).normalized()).norm() < 1e-12);
  CHECK((made->map().normals[1] - Vec3::UnitZ()).norm() < 1e-12);
  CHECK((made->map().normals[3] - Vec3::UnitX()).norm() < 1e-12);
  CHECK(made->map().normals[4] == Vec3::UnitZ());  // of no triangle
  const Mesh cloud{{{0, 0, 0}, {1, 0, 0}}, points_as_triangles(2)};
  CHECK(api::make_deviation(Prepared(cloud), baseline, {}, {.normals = true}, control)->map().normals.empty());
}

TEST_CASE("deviation maker: a cloud stays points, and is thinned with its farthest point") {
  Mesh points;
  for (int i = 0; i < 1000; ++i) points.positions.emplace_back(0.001 * i, 0, i == 777 ? 2.5 : 2);
  points.triangles = points_as_triangles(1000);
  const Mesh plain = shapes::sphere(20);
  const Prepared cloud(points), baseline(plain);
  Control control;
  for (const std::size_t most : {1U, 2U, 3U, 999U, 1000U, 5000U}) {
    api::MapOptions options;
    options.refine = true;
    options.max_triangles = most;
    const auto made = api::make_deviation(cloud, baseline, {}, options, control);
    REQUIRE(made.ok());
    const api::DeviationMap& map = made->map();
    CHECK(map.is_cloud());
    CHECK(map.form == (most < 1000 ? MapForm::decimated : MapForm::as_is));
    CHECK(map.mesh.positions.size() <= most);
    CHECK(map.mesh.positions.size() >= std::min<std::size_t>(most, 1000) / 2);
    CHECK(map.distances.size() == map.mesh.positions.size());
    CHECK(validate(map.mesh, {}, "a").ok());
    CHECK(*std::max_element(map.distances.begin(), map.distances.end()) > 1.5);
  }
}
