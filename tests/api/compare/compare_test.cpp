#include "api/compare/compare.h"

#include <atomic>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/base/digest.h"
#include "api/formats/file/source.h"
#include "api/result/response.h"
#include "tests/eventually.h"

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

// What is told of a comparison, but for the members that no two have in common.
std::string told(const Result<api::Comparison>& result) {
  if (!result) return result.error().part + "|" + result.error().where + "|" + result.error().message;
  auto document = api::document_of(*result);
  for (const char* own : {"id", "view", "timings_ms", "engine"}) document.erase(own);
  return document.dump();
}

using Read = std::optional<Result<api::SharedMesh>>;

api::SharedMesh square() {
  const api::MeshInput input{"a", bytes_of(kSquare), "a.obj", ""};
  Control control;
  return *api::prepare(api::load(input, {}), input, Prepared::Use::once, control);
}

Error wrong(const char* part) { return {ErrorCode::unreadable_mesh, "wrong", part, ""}; }

// Waits until it is stopped, as the reader of a file that never ends.
Result<api::SharedMesh> endless(Control& control) {
  eventually([&] { return control.check() != Interruption::none; });
  return api::not_in_time(control.check(), "it was read");
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

TEST_CASE("compare: files read side by side give the same results and errors as one after the other") {
  const std::string_view soup = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
  const std::string_view files[] = {kSquare, kRaised, soup, "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "v 0 0\n", ""};
  const auto large = [](std::string_view file) {
    std::string all(file);
    while (all.size() < api::kLeastBytesBeside) all += "# a comment\n";
    return all;
  };
  for (const auto& of_a : files) {
    for (const auto& of_b : files) {
      const std::string a = large(of_a), b = large(of_b);
      Options options;
      options.strategy = Strategy::four_point;  // the same bits on any number of threads
      Control control;
      const std::string after = told(compared(a, b, control, options));
      options.threads = 2;
      CHECK(told(compared(a, b, control, options)) == after);
      const auto same_name =
          api::compare({"x", bytes_of(a), "x", ""}, {"x", bytes_of(b), "x", ""}, options, {}, control);
      options.threads = 1;
      CHECK(told(same_name) ==
            told(api::compare({"x", bytes_of(a), "x", ""}, {"x", bytes_of(b), "x", ""}, options, {}, control)));
    }
  }
}

TEST_CASE("compare: the same input twice is read once") {
  Control control;
  api::SharedMeshes meshes;
  const auto compared_as = [&](const char* name_of_b) {
    return api::compare({"a", bytes_of(kSquare), "a.obj", ""}, {name_of_b, bytes_of(kSquare), "a.obj", ""}, {}, {},
                        control, &meshes);
  };
  REQUIRE(compared_as("a").ok());
  CHECK(meshes.a == meshes.b);
  REQUIRE(compared_as("b").ok());
  CHECK(meshes.a != meshes.b);
}

TEST_CASE("read_both: b is read beside a, and the stages add up") {
  Control control;
  api::StageTimes times;
  std::atomic<int> begun{0};
  const auto reader = [&](bool beside, Control&) -> Read {
    CHECK(beside);
    ++begun;
    REQUIRE(eventually([&] { return begun == 2; }));
    return square();
  };
  const auto start = Control::Clock::now();
  REQUIRE(api::read_both(reader, reader, true, control, times).ok());
  CHECK(times.read_a + times.read_b <= ms_since(start));
  const auto alone = [&](bool beside, Control&) -> Read { return CHECK(!beside), square(); };
  REQUIRE(api::read_both(alone, alone, false, control, times).ok());
}

TEST_CASE("read_both: a refused a stops the reader of b alone, and its error is told") {
  Control control;
  api::StageTimes times;
  std::atomic<bool> begun{false}, stopped{false};
  const auto refused = [&](bool, Control&) -> Read {
    eventually([&] { return begun.load(); });
    return wrong("a");
  };
  const auto reader_b = [&](bool, Control& part) -> Read {
    begun = true;
    auto read = endless(part);
    stopped = part.cancelled();
    return read;
  };
  CHECK(api::read_both(refused, reader_b, true, control, times).error().part == "a");
  CHECK(stopped);
  CHECK(control.check() == Interruption::none);
  const auto refused_b = [&](bool, Control&) -> Read { return wrong("b"); };
  CHECK(api::read_both(refused, refused_b, true, control, times).error().part == "a");
  const auto never = [](bool, Control&) -> Read {
    FAIL("b is read after a refused a");
    return wrong("b");
  };
  CHECK(api::read_both(refused, never, false, control, times).error().part == "a");
}

TEST_CASE("read_both: a cancelled job, or one that is late, stops both readers") {
  const auto reader = [](bool, Control& control) -> Read { return endless(control); };
  for (const bool side_by_side : {false, true}) {
    api::StageTimes times;
    Control cancelled;
    const auto cancels = [&](bool, Control& control) -> Read { return cancelled.cancel(), endless(control); };
    CHECK(api::read_both(cancels, reader, side_by_side, cancelled, times).error().message.starts_with("cancelled"));
    Control late(Control::Clock::now() + std::chrono::milliseconds(20));
    CHECK(api::read_both(reader, reader, side_by_side, late, times).error().message.starts_with("timed out"));
  }
}

TEST_CASE("read_both: a mesh that has no room beside the other is read again alone") {
  Control control;
  for (const bool throws : {false, true}) {
    const auto no_room = [throws](bool beside, Control&) -> Read {
      if (!beside) return square();
      if (throws) throw std::bad_alloc();
      return std::nullopt;
    };
    const auto room = [](bool, Control&) -> Read { return square(); };
    api::StageTimes times;
    for (const auto& [a, b] :
         {std::pair<api::MeshReader, api::MeshReader>{no_room, room}, {room, no_room}, {no_room, no_room}})
      CHECK(api::read_both(a, b, true, control, times).ok());
  }
  int calls = 0;
  const auto here = api::reader_here([&](Control&) -> Result<api::SharedMesh> {
    ++calls;
    return calls == 1 ? Result<api::SharedMesh>(api::out_of_memory("a")) : square();
  });
  api::StageTimes times;
  CHECK(api::read_both(here, nullptr, true, control, times).error().part == "a");  // nothing is beside it
  calls = 0;
  CHECK(api::read_both(
            here, [](bool, Control&) -> Read { return square(); }, 2, control, times)
            .ok());
  CHECK(calls == 2);
}

TEST_CASE("read_both: what a reader throws is thrown when both have ended") {
  Control control;
  api::StageTimes times;
  std::atomic<bool> begun{false}, ended{false};
  const auto throws = [&](bool, Control&) -> Read {
    eventually([&] { return begun.load(); });
    throw std::runtime_error("broken");
  };
  const auto waits = [&](bool, Control& part) -> Read {
    begun = true;
    auto read = endless(part);
    ended = true;
    return read;
  };
  CHECK_THROWS_AS((void)api::read_both(throws, waits, true, control, times), std::runtime_error);
  CHECK(ended);
  const auto mesh = [](bool, Control&) -> Read { return square(); };
  CHECK_THROWS_AS((void)api::read_both(mesh, throws, true, control, times), std::runtime_error);
  const auto refused = [](bool, Control&) -> Read { return wrong("a"); };
  CHECK(api::read_both(refused, throws, true, control, times).error().part == "a");
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
