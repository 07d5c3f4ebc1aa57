#include "engine/hausdorff.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "shapes.h"

using namespace meshgauge;

namespace {

Options with(Tolerance tolerance, Direction direction = Direction::a_to_b) {
  Options options;
  options.tolerance = tolerance;
  options.direction = direction;
  return options;
}

Options absolute(double eps, Direction direction = Direction::a_to_b) {
  return with({eps, std::nullopt, std::nullopt}, direction);
}

Outcome run_one(const Mesh& a, const Mesh& b, const Options& options, std::chrono::milliseconds time) {
  Control control(Control::Clock::now() + time);
  const Outcome outcome = measure(a, b, options, control);
  CHECK(outcome.lower <= outcome.upper);
  CHECK(outcome.lower >= 0);
  CHECK(std::isfinite(outcome.upper));
  return outcome;
}

// Returns the outcome of `auto` and checks that its interval meets those of the paper's strategies, finished or not.
Outcome run(const Mesh& a, const Mesh& b, const Options& options) {
  const Outcome outcome = run_one(a, b, options, std::chrono::seconds(60));
  for (const auto strategy : {Strategy::four_point, Strategy::triangle_set}) {
    Options other = options;
    other.strategy = strategy;
    const Outcome check = run_one(a, b, other, std::chrono::milliseconds(100));
    CHECK(outcome.lower <= check.upper);
    CHECK(outcome.upper >= check.lower);
  }
  return outcome;
}

void check_holds(const Outcome& outcome, double truth) {
  CHECK(outcome.lower <= truth);
  CHECK(outcome.upper >= truth);
}

}  // namespace

TEST_CASE("concentric spheres of one tessellation") {
  const Mesh a = shapes::sphere(16, 1.25), b = shapes::sphere(16, 1.0);
  const Outcome out = run(a, b, absolute(1e-6));
  CHECK(out.stop == Stop::converged);
  CHECK(out.met_by == Rule::absolute);
  check_holds(out, 0.25);
  CHECK(out.upper - out.lower <= 1e-6);
  REQUIRE(out.a_to_b);
  CHECK_FALSE(out.b_to_a);
  const Witness& w = *out.a_to_b->bounds.witness;
  CHECK((w.point_a - w.point_b).norm() == doctest::Approx(out.lower).epsilon(1e-6));
  CHECK(w.triangle_a < a.triangles.size());
  CHECK(w.triangle_b < b.triangles.size());
}

TEST_CASE("a square shifted in its plane: the farthest point is a corner") {
  const Outcome out = run(shapes::grid(1), shapes::moved(shapes::grid(1), {0.5, 0.5, 0}), absolute(1e-9));
  CHECK(out.stop == Stop::converged);
  check_holds(out, std::sqrt(0.5));
  CHECK(out.a_to_b->bounds.witness->point_a == Vec3(0, 0, 0));
}

TEST_CASE("the farthest point lies inside a triangle") {
  // The middle of a square of height 0.5 inside a box that is open at the sides: a continuum of maximisers.
  Mesh b = shapes::grid(4, 4, 0);
  const Mesh lid = shapes::grid(4, 4, 1);
  for (const Triangle& t : lid.triangles) {
    b.triangles.push_back({t[0] + 25, t[1] + 25, t[2] + 25});
  }
  b.positions.insert(b.positions.end(), lid.positions.begin(), lid.positions.end());
  const Mesh a = shapes::triangle({0, 0, 0}, {4, 0, 1}, {2, 4, 0.75});
  const Outcome out = run(a, b, absolute(1e-5));
  CHECK(out.stop == Stop::converged);
  check_holds(out, 0.5);
}

TEST_CASE("identical meshes end at once with zero, under every rule") {
  for (const Mesh& mesh : {shapes::cube(), shapes::sphere(20), shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})}) {
    for (const auto direction : {Direction::a_to_b, Direction::b_to_a, Direction::symmetric}) {
      const Outcome out = run(mesh, mesh, absolute(1e-9, direction));
      CHECK(out.stop == Stop::converged);
      CHECK(out.lower == 0);
      CHECK(out.upper == 0);
      CHECK(run(mesh, mesh, with({std::nullopt, 1e-9, std::nullopt}, direction)).stop == Stop::converged);

      Options relative = with({std::nullopt, std::nullopt, 0.01}, direction);
      CHECK(run(mesh, mesh, relative).stop == Stop::converged);
      relative.strategy = Strategy::four_point;  // does not test whether they are the same
      const Outcome searched = run(mesh, mesh, relative);
      CHECK(searched.stop == Stop::precision_floor);
      CHECK(searched.upper <= searched.precision_floor);
    }
  }
}

TEST_CASE("h = 0 without identity: a subset, and a plane cut into other triangles") {
  Mesh face = shapes::cube();
  face.triangles.resize(1);
  const Outcome subset = run(face, shapes::cube(), with({std::nullopt, std::nullopt, 0.01}));
  CHECK(subset.stop == Stop::converged);
  CHECK(subset.upper == 0);

  const Outcome recut = run(shapes::grid(12), shapes::grid(12, 1, 0, true), absolute(1e-3));
  CHECK(recut.stop == Stop::converged);
  check_holds(recut, 0);

  // With a relative rule only `auto` reaches the floor, by the overlay.
  Control control(Control::Clock::now() + std::chrono::seconds(60));
  const Outcome floor = measure(shapes::grid(12), shapes::grid(11), with({std::nullopt, std::nullopt, 0.01}), control);
  CHECK(floor.stop == Stop::precision_floor);
  CHECK(floor.upper <= floor.precision_floor);
  CHECK(floor.upper < 1e-11);
}

TEST_CASE("one triangle in each mesh, and degenerate ones on either side") {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  check_holds(run(shapes::triangle(o, x, y), shapes::triangle(o + z, x + z, y + z), absolute(1e-9)), 1);
  // to a point, from a point, to a segment given in two ways
  check_holds(run(shapes::triangle(o, x, y), shapes::triangle(z, z, z), absolute(1e-9)), std::sqrt(2.0));
  check_holds(run(shapes::triangle(z, z, z), shapes::triangle(o, x, y), absolute(1e-9)), 1);
  check_holds(run(shapes::triangle(o, x, y), shapes::triangle(o, x, o), absolute(1e-9)), 1);
  check_holds(run(shapes::triangle(o, x, y), shapes::triangle(o, x * 0.5, x), absolute(1e-9)), 1);
  Mesh repeated = shapes::triangle(o, x, y);
  repeated.triangles = {{0, 1, 1}};
  check_holds(run(repeated, shapes::triangle(o + z, x + z, y + z), absolute(1e-9)), 1);
  check_holds(run(shapes::triangle(o, o, o), shapes::triangle(o, o, o), absolute(1e-9)), 0);
}

TEST_CASE("a vertex that no triangle uses does not count") {
  Mesh a = shapes::grid(2, 1, 1);
  a.positions.emplace_back(100, 0, 0);
  const Outcome out = run(a, shapes::grid(2), absolute(1e-6));
  CHECK(out.stop == Stop::converged);
  check_holds(out, 1);
}

TEST_CASE("symmetric is the larger of both directions") {
  const Mesh a = shapes::grid(4), b = shapes::grid(4, 2);  // h(a,b) = 0, h(b,a) = sqrt(2)
  const Outcome out = run(a, b, absolute(1e-5, Direction::symmetric));
  CHECK(out.stop == Stop::converged);
  check_holds(out, std::sqrt(2.0));
  REQUIRE(out.a_to_b);
  REQUIRE(out.b_to_a);
  CHECK(out.a_to_b->bounds.lower == 0);
  CHECK(out.b_to_a->bounds.witness->point_a == Vec3(2, 2, 0));
  check_holds(run(a, b, absolute(1e-6, Direction::b_to_a)), std::sqrt(2.0));
  check_holds(run(b, a, absolute(1e-5, Direction::symmetric)), std::sqrt(2.0));
}

TEST_CASE("each stop rule alone ends the work") {
  const Mesh a = shapes::sphere(24, 1), b = shapes::sphere(7, 1.1);
  const Outcome fine = run(a, b, absolute(1e-7));
  for (const Tolerance& tolerance : {Tolerance{1e-3, {}, {}}, Tolerance{{}, 1e-3, {}}, Tolerance{{}, {}, 1e-2}}) {
    const Outcome out = run(a, b, with(tolerance));
    CHECK(out.stop == Stop::converged);
    CHECK(out.lower <= fine.upper);
    CHECK(out.upper >= fine.lower);
    CHECK(out.met_by == (tolerance.absolute ? Rule::absolute : tolerance.diagonal ? Rule::diagonal : Rule::relative));
  }
}

TEST_CASE("every strategy and stencil gives intervals that meet") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20; ++i) {
    const Mesh a = shapes::soup(6, random), b = i % 2 ? shapes::soup(6, random) : shapes::sphere(5);
    const Outcome fine = run(a, b, absolute(1e-7, Direction::symmetric));
    for (const auto strategy : {Strategy::four_point, Strategy::n_point, Strategy::triangle_set}) {
      for (const int points : {10, 31, 109}) {
        Options options = absolute(1e-3, Direction::symmetric);
        options.strategy = strategy;
        options.points = points;
        const Outcome out = run(a, b, options);
        CHECK(out.stop == Stop::converged);
        CHECK(out.lower <= fine.upper);
        CHECK(out.upper >= fine.lower);
      }
    }
  }
}

TEST_CASE("a tolerance below the precision floor ends there") {
  std::mt19937_64 random(6);
  for (int i = 0; i < 50; ++i) {
    const Mesh a = shapes::soup(3, random), b = shapes::soup(3, random);
    const Outcome out = run(a, b, absolute(0));
    CHECK(out.stop == Stop::precision_floor);
    CHECK(out.upper - out.lower <= out.precision_floor);
    CHECK(out.precision_floor < 1e-12);
  }
}

TEST_CASE("far offsets and extreme scales keep the precision of the part's own size") {
  const Mesh a = shapes::sphere(8, 1), b = shapes::sphere(5, 1.0625);
  const Outcome plain = run(a, b, absolute(1e-9));
  for (const int exponent : {-1000, -300, 40, 900}) {
    const double s = std::ldexp(1.0, exponent);
    const Outcome out = run(shapes::scaled(a, s), shapes::scaled(b, s), absolute(1e-9 * s));
    CHECK(out.lower == plain.lower * s);
    CHECK(out.upper == plain.upper * s);
  }
  // Cubes with corners that an offset of 2^40 keeps exact.
  const Mesh c = shapes::cube(1), d = shapes::cube(1, {0.125, 0, 0});
  const Vec3 far(0x1p40, 0x1p40, -0x1p40);
  const Outcome out = run(shapes::moved(c, far), shapes::moved(d, far), absolute(1e-9));
  CHECK(out.stop == Stop::converged);
  check_holds(out, 0.125);
}

TEST_CASE("the interval holds after an interruption at any check") {
  const Mesh a = shapes::sphere(24, 1), b = shapes::sphere(11, 1.03);
  const Outcome fine = run(a, b, absolute(1e-5, Direction::symmetric));
  Control counter;
  (void)measure(a, b, absolute(1e-5, Direction::symmetric), counter);
  REQUIRE(counter.checks() > 100);
  double last_upper = std::numeric_limits<double>::infinity();
  for (std::uint64_t k = 1; k < counter.checks(); k += 1 + counter.checks() / 97) {
    Control control;
    control.cancel_at_check(k);
    const Outcome out = measure(a, b, absolute(1e-5, Direction::symmetric), control);
    CHECK(out.stop == Stop::cancelled);
    CHECK(out.lower <= fine.upper);
    CHECK(out.upper >= fine.lower);
    CHECK(out.upper <= last_upper * 1.0000001);
    last_upper = out.upper;
    CHECK(out.a_to_b->culling.survivors <= a.triangles.size());
  }
}

// Triangles so large and so mixed that one block of them takes longer than the time between two checks of the clock.
TEST_CASE("the interval holds after an interruption in the middle of a block") {
  std::mt19937_64 random(17);
  const Mesh b = shapes::scaled(shapes::soup(3000, random), 0.75);
  // With one block alone no bound of another block hides what is lost.
  for (const auto& [triangles, threads] : {std::pair(300U, 1U), {300U, 3U}, {60U, 1U}}) {
    const Mesh a = shapes::soup(triangles, random);
    Options options = absolute(1e-3);
    options.direction = Direction::a_to_b;
    options.threads = threads;
    options.max_work_items = 2000;
    Control counter;
    const Outcome fine = measure(a, b, options, counter);
    for (std::uint64_t k = 1; k < std::min<std::uint64_t>(counter.checks(), 60); ++k) {
      Control control;
      control.cancel_at_check(k);
      const Outcome out = measure(a, b, options, control);
      CHECK(out.lower <= fine.upper);
      CHECK(out.upper >= fine.lower);
    }
  }
}

TEST_CASE("deadline and memory budget are reasons to stop, with an interval") {
  const Mesh a = shapes::grid(40), b = shapes::grid(40, 1, 0, true);
  Control late(Control::Clock::now());
  CHECK(measure(a, b, absolute(1e-9), late).stop == Stop::timeout);

  Options options = absolute(1e-7);
  options.strategy = Strategy::four_point;
  options.max_memory_bytes = 1 << 20;
  const Outcome out = run(a, b, options);
  CHECK(out.stop == Stop::budget);
  check_holds(out, 0);

  options.max_memory_bytes = std::size_t{1} << 30;
  options.max_work_items = 10;
  const Outcome few = run(a, b, options);
  CHECK(few.stop == Stop::budget);
  CHECK(few.a_to_b->work.subdivisions == 10);
  check_holds(few, 0);

  options.strategy = Strategy::triangle_set;  // its sets of candidates count as memory, too
  options.max_work_items = 1'000'000;
  options.max_memory_bytes = 1 << 20;
  CHECK(run(a, b, options).stop == Stop::budget);
}

TEST_CASE("every progress report has a valid interval, with every strategy") {
  // A ring, and the same ring with one large triangle across its hole.
  Mesh ring = shapes::grid(24);
  std::erase_if(ring.triangles, [&](const Triangle& t) {
    return (ring.positions[t[0]] - Vec3(0.5, 0.5, 0)).cwiseAbs().maxCoeff() < 0.3;
  });
  Mesh across = ring;
  const auto n = static_cast<std::uint32_t>(across.positions.size());
  across.positions.insert(across.positions.end(), {Vec3(0.1, 0.1, 0), Vec3(0.9, 0.1, 0), Vec3(0.1, 0.9, 0)});
  across.triangles.push_back({n, n + 1, n + 2});
  Mesh bowl = shapes::sphere(24);
  std::erase_if(bowl.triangles, [&](const Triangle& t) { return bowl.positions[t[0]].z() > 0; });
  const Mesh lid = shapes::triangle({-0.8, -0.5, -0.3}, {0.8, -0.5, -0.3}, {0, 0.8, -0.3});

  const std::pair<Mesh, Mesh> pairs[] = {{across, ring}, {lid, bowl}, {shapes::sphere(24), shapes::sphere(11, 1.03)}};
  for (const auto& [a, b] : pairs) {
    const Outcome fine = run(a, b, absolute(1e-5));
    for (const auto strategy : {Strategy::automatic, Strategy::four_point, Strategy::n_point, Strategy::triangle_set}) {
      Options options = absolute(1e-3);
      options.strategy = strategy;
      Control control;
      int reports = 0;
      control.watch(
          [&](const Progress& progress) {
            ++reports;
            CHECK(progress.lower <= fine.upper);
            CHECK(progress.upper >= fine.lower);
          },
          std::chrono::milliseconds(0));
      const Outcome watched = measure(a, b, options, control);
      CHECK(reports > 0);  // how many depends on the time that a look takes
      Control alone;
      const Outcome unwatched = measure(a, b, options, alone);
      CHECK(watched.lower == unwatched.lower);
      CHECK(watched.upper == unwatched.upper);
    }
  }
}

TEST_CASE("a stray triangle far away does not make the rest slow or wrong") {
  Mesh a = shapes::sphere(40), b = shapes::sphere(40, 1.01);
  std::mt19937_64 random(8);
  std::shuffle(b.triangles.begin(), b.triangles.end(), random);
  for (Mesh* mesh : {&a, &b}) {
    const auto n = static_cast<std::uint32_t>(mesh->positions.size());
    for (Vec3& p : mesh->positions) p += Vec3(1e8, 1e8, 1e8);
    mesh->positions.emplace_back(-1e8, -1e8, -1e8);
    mesh->triangles.push_back({n, n, n});
  }
  const Outcome out = run_one(a, b, with({std::nullopt, std::nullopt, 0.01}), std::chrono::seconds(60));
  CHECK(out.lower == doctest::Approx(0.01).epsilon(0.02));
  const auto pairs = a.triangles.size() * b.triangles.size();
  CHECK(out.a_to_b->work.triangle_tests < pairs / 20);
}

TEST_CASE("vertices that no triangle uses cost nothing, even if they are NaN") {
  const Mesh a = shapes::grid(12);
  Mesh b = shapes::grid(11);
  b.positions.resize(b.positions.size() + 300'000, Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  const Outcome out = run_one(a, b, absolute(1e-6), std::chrono::seconds(60));
  CHECK(out.stop == Stop::converged);
}

TEST_CASE("the memory budget holds for the first phase, too") {
  const Mesh a = shapes::grid(60), b = shapes::moved(shapes::grid(61, 1, 0, true), {0, 0, 1e-3});
  for (const auto strategy : {Strategy::automatic, Strategy::four_point}) {
    Options options = absolute(1e-12);
    options.strategy = strategy;
    options.max_memory_bytes = 100'000;
    const Outcome out = run_one(a, b, options, std::chrono::seconds(60));
    CHECK(out.stop == Stop::budget);
    check_holds(out, 1e-3);
  }
}
