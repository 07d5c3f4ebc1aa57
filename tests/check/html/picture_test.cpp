#include "check/html/picture.h"

#include <cmath>
#include <fstream>

#include <doctest/doctest.h>

#include "check/criteria.h"
#include "check/run/local.h"
#include "check/run/run.h"
#include "folder.h"
#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

// As if measured: with a witness where `from` and `to` say.
GateOutcome outcome_of(Verdict verdict, const Vec3& from, const Vec3& to) {
  GateOutcome outcome;
  outcome.measured.emplace();
  Measured& measured = *outcome.measured;
  measured.document = {{"meshes", {{"a", {{"format", "stl"}}}}}};
  measured.verdict = verdict;
  measured.lower = measured.upper = (from - to).norm();
  measured.limit = api::DistanceLimit{verdict == Verdict::pass ? 2 * measured.lower : measured.lower / 2};
  measured.witness = check::Witness{true, from, 0, to, 0};
  return outcome;
}

GatePicture picture(const Mesh& candidate, const Mesh& baseline, const GateOutcome& outcome) {
  ThreadPool pool(2);
  Control control;
  return make_picture(Prepared(candidate), Prepared(baseline), outcome, pool, control);
}

// A sphere of which one vertex is pulled out, and that vertex.
struct Pulled {
  Mesh mesh = shapes::sphere(16);
  Vec3 before = mesh.positions[250], after = 1.3 * before;
  Pulled() {
    for (Vec3& p : mesh.positions) {
      if ((p - before).norm() < 1e-9) p = after;
    }
  }
};

void write(const std::string& path, const Mesh& mesh) {
  std::ofstream file(path);
  file.precision(17);
  for (const Vec3& p : mesh.positions) file << "v " << p.x() << " " << p.y() << " " << p.z() << "\n";
  for (const Triangle& t : mesh.triangles) file << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
}

}  // namespace

TEST_CASE("a failed gate has large views of both meshes, with the witness in the middle of its close-up") {
  const Pulled pulled;
  const GatePicture made =
      picture(pulled.mesh, shapes::sphere(16), outcome_of(Verdict::fail, pulled.after, pulled.before));
  CHECK(made.missing.empty());
  REQUIRE(made.surfaces.size() == 2);
  CHECK(made.surfaces[0].candidate);
  CHECK_FALSE(made.surfaces[1].candidate);
  for (const Surface& surface : made.surfaces) {
    CHECK(surface.whole.png.size() > 1000);
    CHECK_FALSE(surface.whole.hidden);
    REQUIRE(surface.close_up);
    CHECK(surface.close_up->from->x == doctest::Approx(0.5 * surface.close_up->camera.width));
    CHECK(surface.close_up->camera.pixel_size() < surface.whole.camera.pixel_size());
    CHECK(surface.whole.close_up ==
          doctest::Approx(surface.close_up->camera.pixel_size() / surface.whole.camera.pixel_size()));
    CHECK(surface.whole.from->x >= 0);
    CHECK(surface.whole.from->x <= surface.whole.camera.width);
  }
  CHECK(made.surfaces[0].histogram.above_limit > 0);
  CHECK(made.surfaces[0].histogram.largest == doctest::Approx(0.3).epsilon(0.1));
  CHECK(made.surfaces[0].scale.top == made.surfaces[1].scale.top);
}

TEST_CASE("a gate that passes has one small view, one direction has the mesh that is measured from") {
  const Pulled pulled;
  GateOutcome outcome = outcome_of(Verdict::pass, pulled.after, pulled.before);
  const GatePicture passed = picture(pulled.mesh, shapes::sphere(16), outcome);
  REQUIRE(passed.surfaces.size() == 1);
  CHECK(passed.surfaces[0].candidate);
  CHECK_FALSE(passed.surfaces[0].close_up);
  outcome.gate.request.options.direction = Direction::b_to_a;
  const GatePicture back = picture(pulled.mesh, shapes::sphere(16), outcome);
  REQUIRE(back.surfaces.size() == 1);
  CHECK_FALSE(back.surfaces[0].candidate);
}

TEST_CASE("a strip alone has no other view, in any direction, and the same bits on any number of threads") {
  const Pulled pulled;
  const Mesh round = shapes::sphere(16);
  for (const Direction direction : {Direction::symmetric, Direction::a_to_b, Direction::b_to_a}) {
    GateOutcome outcome = outcome_of(Verdict::fail, pulled.after, pulled.before);
    outcome.gate.request.options.direction = direction;
    const auto strip = [&](std::size_t threads) {
      ThreadPool pool(threads);
      Control control;
      return make_picture(Prepared(pulled.mesh), Prepared(round), outcome, pool, control, {false, true});
    };
    const GatePicture made = strip(1);
    CHECK(made.surfaces.empty());
    CHECK(made.missing.empty());
    CHECK(made.strip.size() > 1000);
    CHECK(made.strip.size() <= 200'000);
    CHECK(made.strip == strip(3).strip);
  }
}

TEST_CASE("a witness inside the part is shown by a cut") {
  Mesh hollow = shapes::cube(2);
  const Mesh core = shapes::cube(0.2, Vec3(0.9, 0.9, 0.9));
  const auto first = static_cast<std::uint32_t>(hollow.positions.size());
  hollow.positions.insert(hollow.positions.end(), core.positions.begin(), core.positions.end());
  for (const Triangle& t : core.triangles) hollow.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  GateOutcome outcome = outcome_of(Verdict::fail, Vec3(0.9, 0.9, 1.1), Vec3(0.9, 0, 1.1));
  outcome.measured->witness->from_triangle = 12;
  const GatePicture made = picture(hollow, shapes::cube(2), outcome);
  REQUIRE(made.surfaces.size() == 2);
  CHECK(made.surfaces[0].whole.hidden);
  CHECK(made.surfaces[0].close_up->cut);
}

TEST_CASE("a witness that is not on the meshes is not marked") {
  const Mesh mesh = shapes::sphere(8);
  const Vec3 on = mesh.positions[40];
  GateOutcome far = outcome_of(Verdict::fail, Vec3(1e9, 0, 0), on);
  GateOutcome no_triangle = outcome_of(Verdict::fail, on, on * 0.9);
  no_triangle.measured->witness->from_triangle = 1'000'000;
  GateOutcome none = outcome_of(Verdict::undecided, on, on * 0.9);
  none.measured->witness.reset();
  for (const GateOutcome& outcome : {far, no_triangle, none}) {
    const GatePicture made = picture(mesh, shapes::sphere(8, 0.95), outcome);
    REQUIRE(made.surfaces.size() == 2);
    CHECK_FALSE(made.surfaces[0].whole.from);
    CHECK_FALSE(made.surfaces[0].close_up);
  }
}

TEST_CASE("an interrupted picture is missing, with a reason") {
  const Mesh mesh = shapes::sphere(8);
  ThreadPool pool(1);
  Control control;
  control.cancel();
  const GatePicture made = make_picture(
      Prepared(mesh), Prepared(mesh), outcome_of(Verdict::fail, mesh.positions[40], mesh.positions[41]), pool, control);
  CHECK(made.surfaces.empty());
  CHECK(made.missing.find("interrupted") != std::string::npos);
}

TEST_CASE("the files of a gate give a picture while they are those that were measured") {
  const meshgauge::api::test::Folder folder;
  Gate gate;
  gate.name = "gate";
  gate.candidate = folder.path() / "candidate.obj";
  gate.baseline = folder.path() / "baseline.obj";
  set_limit(gate, 0.1);
  write(gate.candidate.string(), Pulled().mesh);
  write(gate.baseline.string(), shapes::sphere(16));
  const std::vector<Gate> gates{gate};
  const Report report = run(gates, *local(gates, std::make_shared<Meshes>(gates), {1, 1}));
  REQUIRE(report.outcomes[0].verdict() == Verdict::fail);

  const auto made = [&] {
    Meshes meshes(gates);
    ThreadPool pool(1);
    Control control;
    return picture_of(report.outcomes[0], meshes, pool, control);
  };
  CHECK(made().surfaces.size() == 2);
  write(gate.candidate.string(), shapes::sphere(9));
  CHECK(made().missing == "'" + gate.candidate.string() + "' is no longer the file that was measured");
  std::filesystem::remove(gate.baseline);
  write(gate.candidate.string(), Pulled().mesh);
  CHECK(made().missing.find("baseline.obj") != std::string::npos);
  CHECK(made().surfaces.empty());
}
