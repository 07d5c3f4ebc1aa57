#include "api/compare/compare.h"

#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include "api/base/digest.h"

using namespace meshgauge;

namespace {

constexpr std::string_view kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
constexpr std::string_view kRaised = "v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 2\nf 1 2 3\nf 1 3 4\n";

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

Result<api::Comparison> compared(std::string_view a, std::string_view b, Control& control, Options options = {}) {
  return api::compare({"a", bytes_of(a), "a.obj", ""}, {"b", bytes_of(b), "b.obj", ""}, options, {}, control);
}

}  // namespace

TEST_CASE("compare: two parallel squares") {
  Control control;
  Options options;
  options.tolerance = {1e-9, std::nullopt, std::nullopt};
  const auto result = compared(kSquare, kRaised, control, options);
  REQUIRE(result.ok());
  CHECK(result->outcome.lower <= 2.0);
  CHECK(result->outcome.upper >= 2.0);
  CHECK(result->outcome.upper - result->outcome.lower <= 1e-9);
  CHECK(result->id.size() == 32);
  CHECK(result->a.triangles == 2);
  CHECK(result->a.vertices == 4);
  CHECK(result->a.notes.polygons.count == 1);
  CHECK(result->a.bytes == kSquare.size());
  CHECK(result->a.sha256 == api::sha256_hex(bytes_of(kSquare)));
  CHECK(result->b.bbox.low == Vec3(0, 0, 2));
  CHECK(result->times.total >= result->times.read_a);
}

TEST_CASE("compare: a mesh without shared vertices is welded") {
  Control control;
  const std::string soup = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
  const auto result = compared(soup, kSquare, control);
  REQUIRE(result.ok());
  CHECK(result->a.vertices == 4);
  CHECK(result->a.notes.welded_vertices == 2);
  CHECK(result->b.notes.welded_vertices == 0);
  CHECK(result->outcome.lower == 0);
}

TEST_CASE("compare: a name and a media type that contradict the content are reported") {
  Control control;
  const auto result = api::compare({"a", bytes_of(kSquare), "a.stl", "model/obj"},
                                   {"b", bytes_of(kRaised), "", "model/ply"}, {}, {}, control);
  REQUIRE(result.ok());
  CHECK(result->a.notes.filename_says == api::Format::stl);
  CHECK(result->a.notes.media_type_says == std::nullopt);
  CHECK(result->b.notes.media_type_says == api::Format::ply);
}

TEST_CASE("compare: an error names the part") {
  Control control;
  const auto result = compared(kSquare, "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", control);
  REQUIRE(!result.ok());
  CHECK(result.error().part == "b");
}

TEST_CASE("compare: a timeout while reading is an error, while measuring it is not") {
  Control late(Control::Clock::now() - std::chrono::seconds(1));
  const auto unread = compared(kSquare, kRaised, late);
  REQUIRE(!unread.ok());
  CHECK(unread.error().code == ErrorCode::out_of_time);

  Control control;
  control.cancel_at_check(5);  // after those before and after a, before and after b
  const auto cut_short = compared(kSquare, kRaised, control);
  REQUIRE(cut_short.ok());
  CHECK(cut_short->outcome.stop == Stop::cancelled);
  CHECK(cut_short->outcome.upper >= 2.0);
}

TEST_CASE("compare: cancelling stops the collection of facts of a large mesh") {
  Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
  mesh.triangles.assign(300'000, {0, 1, 2});
  Control control;
  control.cancel_at_check(1);
  const auto result = api::prepare(api::LoadedMesh{mesh, api::Format::obj, {}, "", nullptr}, {"a", {}, "", ""},
                                   Prepared::Use::once, control);
  REQUIRE(!result.ok());
  CHECK(result.error().code == ErrorCode::out_of_time);
  CHECK(control.checks() == 3);  // in each of two passes, and after them
}

TEST_CASE("compare: prepared meshes give an interval, whenever the job is cancelled") {
  const auto prepared = [](std::string_view text, const char* part) {
    const api::MeshInput input{part, bytes_of(text), "a.obj", ""};
    Control control;
    return *api::prepare(api::load(input, {}), input, Prepared::Use::once, control);
  };
  Control control;
  control.cancel();
  const auto result = api::compare(prepared(kSquare, "a"), prepared(kRaised, "b"), {}, control);
  REQUIRE(result.ok());
  CHECK(result->outcome.stop == Stop::cancelled);
  CHECK(result->outcome.lower <= 2.0);
  CHECK(result->outcome.upper >= 2.0);
}

TEST_CASE("compare: the topology of a mesh is kept, unless examining it was interrupted") {
  Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
  mesh.triangles.assign(20'000, {0, 1, 2});
  Control control;
  const auto prepared = api::prepare(api::LoadedMesh{mesh, api::Format::obj, {}, "", nullptr}, {"a", {}, "", ""},
                                     Prepared::Use::once, control);
  api::ComparisonOptions options;
  options.topology = true;
  control.cancel();
  const auto cut_short = api::compare(*prepared, *prepared, options, control);
  REQUIRE(cut_short.ok());
  CHECK(!cut_short->a.topology);
  CHECK(cut_short->outcome.stop == Stop::cancelled);
  Control again;
  options.units = {api::LengthUnit::inch, api::LengthUnit::inch, api::LengthUnit::millimeter, false};
  options.max_distance = 1;
  const auto whole = api::compare(*prepared, *prepared, options, again);
  REQUIRE(whole.ok());
  CHECK(whole->a.topology->non_manifold.count == 3);
  CHECK(whole->b.topology->non_manifold.first.maxCoeff() == 12.7);  // in the unit of the result
  CHECK((*prepared)->topology([] { return true; })->edges == 3);    // known already
}

TEST_CASE("compare: each comparison has an id of its own") {
  Control control;
  CHECK(compared(kSquare, kSquare, control)->id != compared(kSquare, kSquare, control)->id);
}

TEST_CASE("digest: SHA-256 of the standard's examples") {
  CHECK(api::sha256_hex({}) == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  api::Sha256 pieces;
  for (const std::string_view piece : {"", "a", "bc"}) pieces.update(bytes_of(piece));
  CHECK(pieces.hex() == api::sha256_hex(bytes_of("abc")));
  CHECK(api::sha256_hex(bytes_of("abc")) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST_CASE("compare: meshes are converted to the limit's unit, and a mesh has distance 0 from itself") {
  Options engine;
  engine.tolerance = {std::nullopt, 1e-9, std::nullopt};
  engine.max_distance = 60;
  api::ComparisonOptions options(engine,
                                 {api::LengthUnit::inch, api::LengthUnit::meter, api::LengthUnit::millimeter, false});
  Control control;
  const auto compare = [&](std::string_view a, std::string_view b) {
    return api::compare({"a", bytes_of(a), "a.obj", ""}, {"b", bytes_of(b), "b.obj", ""}, options, {}, control);
  };
  const auto raised = compare(kSquare, kRaised);
  REQUIRE(raised.ok());
  CHECK(raised->units.result.unit == api::LengthUnit::millimeter);
  CHECK(raised->outcome.lower > 1999);  // 2 m up
  CHECK(raised->a.diagonal < 2);        // facts of the file are in its own unit
  options.units.b = api::LengthUnit::inch;
  options.max_distance = 0;
  const auto same = compare(kSquare, kSquare);
  REQUIRE(same.ok());
  CHECK(same->outcome.upper == 0);
  const auto lifted = compare(kSquare, kRaised);
  REQUIRE(lifted.ok());
  CHECK(lifted->outcome.lower <= 50.8);
  CHECK(lifted->outcome.upper >= 50.8);
}

TEST_CASE("compare: a mesh that is too large for the unit of the result is refused by name") {
  const std::string large = "v 0 0 0\nv 1e305 0 0\nv 0 1 0\nf 1 2 3\n";
  const api::ComparisonOptions options({}, {api::LengthUnit::foot, api::LengthUnit::micron, {}});
  Control control;
  const auto result =
      api::compare({"a", bytes_of(large), "a.obj", ""}, {"b", bytes_of(kSquare), "b.obj", ""}, options, {}, control);
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().code == ErrorCode::coordinate_too_large);
  CHECK(result.error().part == "a");
}

TEST_CASE("compare: a mesh for Use::often caches its last conversion, one for Use::once does not") {
  Control control;
  const api::MeshInput input{"a", bytes_of(kSquare), "a.obj", ""};
  const auto prepared = [&](Prepared::Use use) { return *api::prepare(api::load(input, {}), input, use, control); };
  const Factor inches{127, 5}, metres{1, 1000};

  const auto once = prepared(Prepared::Use::once);
  CHECK(*api::in_unit(once, "a", inches, control) != *api::in_unit(once, "a", inches, control));

  const auto often = prepared(Prepared::Use::often);
  const std::size_t bytes = often->bytes();
  const auto first = *api::in_unit(often, "a", inches, control);
  CHECK(first == *api::in_unit(often, "a", inches, control));
  CHECK(often->bytes() > bytes);
  const auto other = *api::in_unit(often, "a", metres, control);
  CHECK(other != first);
  CHECK(first->mesh().positions[2] == Vec3(25.4, 25.4, 0));  // its owners may still use it
  CHECK(other->mesh().positions[2] == Vec3(0.001, 0.001, 0));
  CHECK(often->mesh.mesh().positions[2] == Vec3(1, 1, 0));
}

TEST_CASE("compare: a point cloud is measured from, and not to") {
  const std::string cloud = "v 0 0 0.25\nv 1 0 0.5\nv 0.5 0.5 0\n";
  Control control;
  Options options;
  options.direction = Direction::a_to_b;
  const auto result = compared(cloud, kSquare, control, options);
  REQUIRE(result.ok());
  CHECK(result->a.notes.cloud);
  CHECK(result->a.triangles == 0);
  CHECK(result->a.degenerate == 0);
  CHECK(result->a.vertices == 3);
  CHECK(result->outcome.lower <= 0.5);
  CHECK(result->outcome.upper >= 0.5);
  CHECK(result->outcome.upper - result->outcome.lower < 1e-12);

  const auto refusal = [&](std::string_view a, std::string_view b, Direction direction) {
    options.direction = direction;
    const auto refused = compared(a, b, control, options);
    REQUIRE(!refused.ok());
    CHECK(refused.error().code == ErrorCode::empty_mesh);
    return refused.error();
  };
  for (const Direction direction : {Direction::symmetric, Direction::b_to_a}) {
    const Error error = refusal(cloud, kSquare, direction);
    CHECK(error.part == "a");
    CHECK(
        error.message ==
        "'a' has no triangles: it is a point cloud of 3 points, and distances are measured from it, not to it; ask for "
        "the direction a_to_b");
  }
  for (const Direction direction : {Direction::symmetric, Direction::a_to_b}) {
    const Error error = refusal(kSquare, cloud, direction);
    CHECK(error.part == "b");
    CHECK(error.message.ends_with("ask for the direction b_to_a"));
    CHECK(refusal(cloud, cloud, direction).message.ends_with("one of both needs triangles"));
  }
  options.direction = Direction::b_to_a;
  CHECK(compared(kSquare, cloud, control, options).ok());
}
