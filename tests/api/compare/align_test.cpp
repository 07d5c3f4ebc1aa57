#include "api/compare/align.h"

#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "api/compare/compare.h"
#include "api/options/request.h"
#include "api/result/response.h"
#include "api/result/result_document.h"
#include "shapes.h"

using namespace meshgauge;
using Json = nlohmann::ordered_json;

namespace {

// A box with unequal sides and a dent, which fits itself in one pose alone.
Mesh dented_box() {
  Mesh mesh = shapes::unwelded(shapes::cube(1));
  for (Vec3& p : mesh.positions) p = p.cwiseProduct(Vec3(3, 2, 1));
  mesh.positions.insert(mesh.positions.end(), {{1, 1, 1}, {1.5, 1, 1}, {1, 1.25, 2}});
  const auto last = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.triangles.push_back({last - 3, last - 2, last - 1});
  return mesh;
}

RigidMotion some_motion() {
  return {Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix(), Vec3(0.2, -0.1, 0.15)};
}

std::string obj_text(const Mesh& mesh, bool faces = true) {
  std::string text;
  const auto line = [&text](const char* what, const auto& a, const auto& b, const auto& c) {
    for (const std::string& word : {std::string(what), Json(a).dump(), Json(b).dump(), Json(c).dump()})
      text += word + " ";
    text += "\n";
  };
  for (const Vec3& p : mesh.positions) line("v", p.x(), p.y(), p.z());
  for (const Triangle& t : mesh.triangles) {
    if (faces) line("f", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  return text;
}

Mesh moved_by(Mesh mesh, const RigidMotion& motion) {
  for (Vec3& p : mesh.positions) p = motion(p);
  return mesh;
}

Result<std::optional<AlignOptions>> parsed_align(const std::string& text) {
  const auto read = api::parse_options("{\"align\": " + (text.starts_with('{') ? text : "\"" + text + "\"") + "}");
  if (!read) return read.error();
  return read->options.align;
}

Result<api::Comparison> aligned_result(const std::string& a, const std::string& b, api::ComparisonOptions options,
                                       Control& control, api::SharedMeshes* meshes = nullptr) {
  const auto bytes = [](const std::string& text) { return std::as_bytes(std::span(text)); };
  return api::compare({"a", bytes(a), "a.obj", ""}, {"b", bytes(b), "b.obj", ""}, options, {}, control, meshes);
}

Result<api::Comparison> aligned_result(const std::string& a, const std::string& b, const std::string& align,
                                       const api::AskedUnits& units = {}) {
  api::ComparisonOptions options;
  options.align = *parsed_align(align);
  options.units = units;
  Control control;
  return aligned_result(a, b, options, control);
}

std::string transform_of(const std::string& rotation_and_shift, const char* order = "row_major") {
  return R"({"transform": {")" + std::string(order) + R"(": [)" + rotation_and_shift + "]}}";
}

Error align_refusal(const std::string& align) {
  const auto read = parsed_align(align);
  REQUIRE_FALSE(read.ok());
  CHECK(read.error().code == ErrorCode::invalid_request);
  return read.error();
}

}  // namespace

TEST_CASE("align: the option in all its forms") {
  CHECK_FALSE(*parsed_align("none"));
  CHECK(*parsed_align("rigid") == AlignOptions());
  CHECK(*parsed_align("{}") == AlignOptions());
  const auto all = *parsed_align(R"({"principal_axes": true, "overlap": 0.5, "fit": true})");
  CHECK(*all == AlignOptions{{}, true, true, 0.5});

  const auto rows = *parsed_align(transform_of("0,-1,0,5, 1,0,0,6, 0,0,1,7, 0,0,0,1"));
  const auto columns = *parsed_align(transform_of("0,1,0,0, -1,0,0,0, 0,0,1,0, 5,6,7,1", "column_major"));
  CHECK(rows == columns);
  CHECK_FALSE(rows->fit);
  CHECK(rows->start(Vec3(1, 0, 0)) == Vec3(5, 7, 7));
}

TEST_CASE("align: another reader gets the same options") {
  AlignOptions options{some_motion(), true, true, 0.75};
  for (int i = 0; i < 2; ++i) {
    CHECK(*parsed_align(api::json_of(options).dump()) == options);
    options = {some_motion(), false};
  }
  CHECK(*parsed_align(api::json_of(AlignOptions()).dump()) == AlignOptions());
}

TEST_CASE("align: what is refused is named, with what was seen") {
  CHECK(align_refusal("stiff").message.find("must be none, rigid, or an object") != std::string::npos);
  CHECK(align_refusal(R"({"overlapp": 1})").where == "/align/overlapp");
  CHECK(align_refusal(R"({"overlap": 0.05})").where == "/align/overlap");
  CHECK(align_refusal(R"({"overlap": "all"})").where == "/align/overlap");
  CHECK(align_refusal(R"({"fit": 1})").where == "/align/fit");
  CHECK(align_refusal(R"({"fit": false})").message == "/align/fit is false, so /align needs a transform");
  CHECK(align_refusal(R"({"transform": [1]})").where == "/align/transform");
  CHECK(align_refusal(R"({"transform": {}})").where == "/align/transform");
  CHECK(align_refusal(R"({"transform": {"rows": []}})").where == "/align/transform");
  CHECK(align_refusal(transform_of("1, 2, 3")).message ==
        "/align/transform/row_major must be an array of 16 numbers, not one of 3");
  CHECK(align_refusal(transform_of("1,0,0,null, 0,1,0,0, 0,0,1,0, 0,0,0,1")).where == "/align/transform/row_major/3");
  CHECK(align_refusal(transform_of("1,0,0,1e308, 0,1,0,0, 0,0,1,0, 0,0,0,1")).where == "/align/transform/row_major/3");
  const std::string axes = transform_of("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1");
  CHECK(align_refusal(axes.substr(0, axes.size() - 1) + R"(, "principal_axes": true})").where ==
        "/align/principal_axes");
  const auto says = [](const Error& error, const char* what) {
    CAPTURE(error.message);
    CHECK(error.message.find(what) != std::string::npos);
  };
  says(align_refusal(transform_of("1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1")), "the other order");
  says(align_refusal(transform_of("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2")), "must end with the row 0 0 0 1, not 0 0 0 2");
  says(align_refusal(transform_of("1.1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), "scales or shears");
  says(align_refusal(transform_of("1,0.001,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")),
       "(limit 4e-06; write at least six decimals)");
  says(align_refusal(transform_of("1e300,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1")), "scales or shears");
  says(align_refusal(transform_of("0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,1")), "scales or shears");
  says(align_refusal(transform_of("1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,0,1")), "it mirrors");
}

TEST_CASE("align: a rotation with six decimals is mended, an exact one is used as it is") {
  const auto six = *parsed_align(transform_of("0.866025,-0.5,0,0, 0.5,0.866025,0,0, 0,0,1,0, 0,0,0,1"));
  CHECK(off_orthonormal(six->start.rotation) <= RigidMotion::kOrthonormal);
  const RigidMotion exact = some_motion();
  CHECK((*parsed_align(api::json_of(AlignOptions{exact, false}).dump()))->start == exact);
}

TEST_CASE("align: a displaced copy is measured in the pose of the other, and the result says so") {
  const std::string b = obj_text(dented_box()), a = obj_text(moved_by(dented_box(), some_motion()));
  CHECK(aligned_result(a, b, "none")->outcome.lower > 0.1);
  CHECK(api::to_json(*aligned_result(a, b, "none")).find("alignment") == std::string::npos);

  const auto fitted = aligned_result(a, b, "rigid");
  REQUIRE(fitted.ok());
  CHECK(fitted->outcome.upper < 1e-9);
  CHECK(fitted->outcome.precision_floor > 0);
  const Json document = Json::parse(api::to_json(*fitted));
  const Json& alignment = document["alignment"];
  CHECK(alignment["moved"] == "a");
  CHECK(alignment["method"] == "best_fit");
  CHECK(alignment["angle_degrees"].get<double>() == doctest::Approx(0.3 * 180 / std::acos(-1.0)));
  CHECK(alignment["residual"].get<double>() < 1e-9);
  CHECK(alignment["residual_before"].get<double>() > 0.01);
  CHECK(document["timings_ms"].contains("align"));
  CHECK(document["notes"][0].get<std::string>().starts_with("mesh a was moved before it was measured, by best fit: "));

  // The reported transform repeats the measurement, to the last bit.
  const auto again = aligned_result(a, b, Json{{"transform", alignment["transform"]}}.dump());
  REQUIRE(again.ok());
  CHECK(again->outcome.lower == fitted->outcome.lower);
  CHECK(again->outcome.upper == fitted->outcome.upper);
  CHECK(again->outcome.precision_floor == fitted->outcome.precision_floor);
  CHECK(api::to_json(*again).find("by the transform given") != std::string::npos);
}

TEST_CASE("align: the transform acts in the unit of the result, and areas and maps are of the moved mesh") {
  const std::string mesh = obj_text(dented_box());
  const std::string by_mm = transform_of("1,0,0,25.4, 0,1,0,0, 0,0,1,0, 0,0,0,1");
  api::ComparisonOptions options;
  options.align = *parsed_align(by_mm);
  options.units = {api::LengthUnit::inch, api::LengthUnit::millimeter, {}, false};
  options.areas = AreaOptions{};
  options.areas->mean = true;
  options.direction = Direction::a_to_b;
  Mesh inches = dented_box();
  for (Vec3& p : inches.positions) p = (p - Vec3(25.4, 0, 0)) / 25.4;
  Control control;
  api::SharedMeshes meshes;
  const auto result = aligned_result(obj_text(inches), mesh, options, control, &meshes);
  REQUIRE(result.ok());
  CHECK(result->outcome.upper < 1e-12);
  CHECK(result->outcome.areas->a_to_b->mean->upper < 1e-12);

  const auto facts = api::result_facts(Json::parse(api::to_json(*result)), api::Side::a);
  REQUIRE(facts.ok());
  REQUIRE(facts->motion);
  const auto pair = api::in_unit_of_result(meshes.a, meshes.b, facts->units, facts->motion, control);
  REQUIRE(pair.ok());
  CHECK((pair->a->box().high - pair->b->box().high).norm() < 1e-12);
}

TEST_CASE("align: a point cloud is aligned, on either side") {
  Mesh dense = dented_box();
  std::vector<Vec3> points;
  for (const Triangle& t : dense.triangles) {
    for (int i = 0; i <= 8; ++i) {
      for (int j = 0; i + j <= 8; ++j)
        points.push_back((i * dense.positions[t[0]] + j * dense.positions[t[1]] + (8 - i - j) * dense.positions[t[2]]) /
                         8);
    }
  }
  Mesh scan;
  scan.positions = points;
  Control control;
  api::ComparisonOptions options;
  options.align.emplace();
  options.direction = Direction::a_to_b;
  const auto result = aligned_result(obj_text(moved_by(scan, some_motion()), false), obj_text(dense), options, control);
  REQUIRE(result.ok());
  CHECK(result->outcome.upper < 1e-9);
  options.direction = Direction::b_to_a;
  const auto other = aligned_result(obj_text(moved_by(dense, some_motion())), obj_text(scan, false), options, control);
  REQUIRE(other.ok());
  CHECK(other->outcome.upper < 1e-9);
}

TEST_CASE("align: a move out of range and an interruption are errors") {
  const std::string mesh = obj_text(dented_box());
  const auto far = aligned_result(obj_text(shapes::scaled(dented_box(), 0x1p1017)), mesh,
                                  transform_of("1,0,0,1.1e307, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
  REQUIRE_FALSE(far.ok());
  CHECK(far.error().code == ErrorCode::coordinate_too_large);
  CHECK(far.error().part == "a");

  api::ComparisonOptions options;
  options.align.emplace();
  Control whole;
  REQUIRE(aligned_result(mesh, mesh, options, whole).ok());
  std::size_t refused = 0;
  for (std::uint64_t n = 1; n < whole.checks(); n += 1 + whole.checks() / 100) {
    Control control;
    control.cancel_at_check(n);
    const auto result = aligned_result(obj_text(moved_by(dented_box(), some_motion())), mesh, options, control);
    if (result) continue;
    ++refused;
    CHECK(result.error().code == ErrorCode::out_of_time);
  }
  CHECK(refused > 10);
}

TEST_CASE("align: a result whose transform is no motion is no result") {
  Json document = Json::parse(api::to_json(*aligned_result(obj_text(dented_box()), obj_text(dented_box()), "rigid")));
  CHECK(api::result_facts(document, api::Side::a).ok());
  document["alignment"]["transform"]["row_major"][0] = 7;
  CHECK_FALSE(api::result_facts(document, api::Side::a).ok());
  document["alignment"] = 3;
  CHECK_FALSE(api::result_facts(document, api::Side::a).ok());
}
