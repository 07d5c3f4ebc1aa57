// Certified areas of measure() for shapes whose distribution is known.
#include "engine/area.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>

#include "engine/hausdorff.h"
#include "engine/tree/prepared.h"
#include "same_outcome.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

AreaOptions everything(const std::vector<double>& limits) {
  AreaOptions asked;
  for (const double limit : limits) asked.beyond.push_back({limit, {}});
  asked.quantiles = {0.5, 0.95, 0.99};
  asked.mean = true;
  return asked;
}

Outcome measured(const Mesh& a, const Mesh& b, const AreaOptions& asked, Control& control, unsigned threads = 1,
                 Direction direction = Direction::a_to_b) {
  Options options;
  options.direction = direction;
  options.areas = asked;
  options.threads = threads;
  return measure(a, b, options, control);
}

AreaBounds from_a(const Mesh& a, const Mesh& b, const AreaOptions& asked, unsigned threads = 1) {
  Control control;
  return measured(a, b, asked, control, threads).areas.value().a_to_b.value();
}

// `off`: by how much the expected value may err.
bool holds(const AreaInterval& found, double value, double off = 1e-12) {
  return found.lower <= value + off && value - off <= found.upper;
}

bool same(const AreaBounds& x, const AreaBounds& y) {
  const auto equal = [](const AreaInterval& a, const AreaInterval& b) {
    return same_bits(a.lower, b.lower) && same_bits(a.upper, b.upper);
  };
  return std::equal(x.beyond.begin(), x.beyond.end(), y.beyond.begin(), equal) &&
         std::equal(x.quantiles.begin(), x.quantiles.end(), y.quantiles.begin(), equal) && equal(*x.mean, *y.mean) &&
         equal(*x.rms, *y.rms) && x.pieces == y.pieces && x.stop == y.stop;
}

// The unit square, tilted so that its height over the plane z = 0 grows from 0 to 1.
Mesh tilted() { return {{{0, 0, 0}, {1, 0, 1}, {1, 1, 1}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}}; }
Mesh plane() { return shapes::moved(shapes::grid(4, 8), {-4, -4, 0}); }

}  // namespace

TEST_CASE("area: a tilted patch over a plane, with distances uniform on [0, 1]") {
  const AreaOptions asked = everything({0, 0.25, 0.9, 1.5});
  const AreaBounds found = from_a(tilted(), plane(), asked);
  CHECK(found.stop == AreaStop::complete);
  const double shares[] = {1, 0.75, 0.1, 0};
  for (std::size_t k = 0; k < std::size(shares); ++k) {
    CAPTURE(k);
    CHECK(holds(found.beyond[k], shares[k]));
    CHECK(found.beyond[k].upper - found.beyond[k].lower <= asked.share_tolerance);
  }
  CHECK(found.beyond[3].upper == 0);
  for (std::size_t q = 0; q < 3; ++q) {
    CAPTURE(q);
    CHECK(holds(found.quantiles[q], asked.quantiles[q]));
    CHECK(found.quantiles[q].upper - found.quantiles[q].lower <= asked.length_tolerance);
  }
  CHECK(holds(*found.mean, 0.5));
  CHECK(holds(*found.rms, std::sqrt(1.0 / 3)));
}

TEST_CASE("area: shares alone leave out what is within every limit or beyond all") {
  Mesh fine = shapes::grid(40);
  for (Vec3& p : fine.positions) p.z() = p.x();
  AreaOptions asked;
  asked.beyond = {{0.25, {}}, {0.9, {}}};
  for (const unsigned threads : {1U, 3U}) {
    const AreaBounds found = from_a(fine, plane(), asked, threads);
    CHECK(found.stop == AreaStop::complete);
    for (const auto& [k, share] : {std::pair(0, 0.75), std::pair(1, 0.1)}) {
      CAPTURE(k);
      const AreaInterval& interval = found.beyond[static_cast<std::size_t>(k)];
      CHECK(holds(interval, share));
      CHECK(interval.upper - interval.lower <= asked.share_tolerance);
    }
  }
  const AreaBounds far = from_a(shapes::moved(fine, {0, 0, 5}), plane(), asked);
  CHECK(far.beyond[1].lower == 1);
}

TEST_CASE("area: a square and the point in its middle") {
  const Mesh point = shapes::triangle({0.5, 0.5, 0}, {0.5, 0.5, 0}, {0.5, 0.5, 0});
  const AreaOptions asked = everything({0.25, 0.5, 0.75});
  const AreaBounds found = from_a(shapes::grid(1), point, asked);
  CHECK(found.stop == AreaStop::complete);
  const auto within = [](double r) {  // the area of the circle inside of the square, r <= sqrt(1/2)
    const double beyond = r > 0.5 ? r * r * std::acos(0.5 / r) - 0.5 * std::sqrt(r * r - 0.25) : 0;
    return std::numbers::pi * r * r - 4 * beyond;
  };
  CHECK(holds(found.beyond[0], 1 - within(0.25)));
  CHECK(holds(found.beyond[1], 1 - within(0.5)));
  CHECK(found.beyond[2].upper == 0);
  CHECK(holds(*found.mean, (std::sqrt(2.0) + std::asinh(1.0)) / 6));
  CHECK(holds(*found.rms, std::sqrt(1.0 / 6)));
  for (std::size_t q = 0; q < 3; ++q) {
    CHECK(within(found.quantiles[q].lower) <= asked.quantiles[q] + 1e-12);
    CHECK(within(std::min(found.quantiles[q].upper, std::sqrt(0.5))) >= asked.quantiles[q] - 1e-12);
  }
}

TEST_CASE("area: a cube and a moved one, in both directions and far from 0") {
  for (const double offset : {0.0, 1e6}) {
    CAPTURE(offset);
    const Vec3 at = Vec3::Constant(offset);
    const Mesh a = shapes::cube(1, at), b = shapes::cube(1, at + Vec3(0.25, 0, 0));
    AreaOptions asked = everything({0.1, 0.2});
    asked.quantiles = {0.9497};  // within a triangle  // p50 is where the distance begins to differ from 0
    Control control;
    const Outcome outcome = measured(a, b, asked, control, 1, Direction::symmetric);
    // One face is 0.25 away; its opposite is inside, with the distance from the nearest side, at most 0.25; strips of
    // four faces are 0 .. 0.25 away.
    const auto inside_beyond = [](double t) { return (1 - 2 * t) * (1 - 2 * t); };
    for (const auto& found : {*outcome.areas->a_to_b, *outcome.areas->b_to_a}) {
      CHECK(found.stop == AreaStop::complete);
      for (std::size_t k = 0; k < 2; ++k) {
        const double t = k == 0 ? 0.1 : 0.2;
        CHECK(holds(found.beyond[k], (1 + inside_beyond(t) + 4 * (0.25 - t)) / 6, 1e-9));
      }
    }
  }
}

TEST_CASE("area: a share alone is left undecided at once where the distance equals the limit everywhere") {
  AreaOptions asked;
  asked.beyond = {{0.5, {}}};
  const AreaBounds found = from_a(shapes::grid(3, 1, 0.5), plane(), asked);
  CHECK(found.stop == AreaStop::precision_floor);
  CHECK(found.pieces < 1000);
}

TEST_CASE("area: a distance that equals the limit everywhere is left undecided, at once") {
  const AreaBounds found = from_a(shapes::grid(3, 1, 0.5), plane(), everything({0.5}));
  CHECK(found.stop == AreaStop::precision_floor);
  CHECK(found.beyond[0].lower == 0);
  CHECK(found.beyond[0].upper == 1);
  CHECK(holds(*found.mean, 0.5));
  CHECK(found.mean->upper - found.mean->lower < 1e-12);
  CHECK(from_a(shapes::grid(3, 1, 0.5), plane(), everything({0.4999})).beyond[0].lower == 1);
}

TEST_CASE("area: degenerate triangles weigh nothing, and a mesh of them alone has no area") {
  Mesh a = tilted();
  const auto first = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), {{0, 0, 5}, {1, 0, 5}, {2, 0, 5}});
  a.triangles.push_back({first, first + 1, first + 2});
  AreaOptions share;
  share.beyond = {{0.25, {}}};
  CHECK(holds(from_a(a, plane(), everything({0.25})).beyond[0], 0.75));
  CHECK(holds(from_a(a, plane(), share).beyond[0], 0.75));
  a.triangles.erase(a.triangles.begin(), a.triangles.begin() + 2);
  const AreaBounds none = from_a(a, plane(), everything({0.25}));
  CHECK(none.stop == AreaStop::no_area);
  CHECK(none.beyond[0].lower == 0);
  CHECK(none.beyond[0].upper == 1);
  CHECK(none.quantiles[0].upper >= 5);
}

TEST_CASE("area: a gate ends the search on the right side") {
  AreaOptions asked;
  asked.share_tolerance = 1e-2;
  const Mesh a = shapes::sphere(6, 1.3, {0.1, 0, 0}), b = shapes::sphere(5);
  asked.beyond = {{0.3, {}}};
  const AreaBounds exact = from_a(a, b, asked);
  REQUIRE(exact.stop == AreaStop::complete);
  for (const double factor : {0.5, 0.9, 1.1, 2.0}) {
    CAPTURE(factor);
    asked.beyond = {{0.3, exact.beyond[0].upper * factor}};
    const AreaBounds gated = from_a(a, b, asked);
    CHECK(gated.pieces <= exact.pieces);
    CHECK((gated.beyond[0].upper <= *asked.beyond[0].max_share) == (factor > 1));
    CHECK((gated.beyond[0].lower > *asked.beyond[0].max_share) == (factor < 1));
  }
}

TEST_CASE("area: a gate is decided where its share is closer to its limit than the tolerance") {
  const Mesh a = shapes::sphere(6, 1.1, {0.1, 0.05, 0}), b = shapes::sphere(5);
  AreaOptions asked;
  asked.beyond = {{0.1, {}}};
  asked.share_tolerance = 1e-5;
  const AreaInterval exact = from_a(a, b, asked).beyond[0];
  asked.share_tolerance = 0.5;
  for (const double limit : {exact.lower - 1e-4, exact.upper + 1e-4}) {
    asked.beyond = {{0.1, limit}};
    const AreaBounds gated = from_a(a, b, asked);
    CHECK(gated.stop == AreaStop::complete);
    CHECK((gated.beyond[0].lower > limit) == (limit < exact.lower));
    CHECK((gated.beyond[0].upper <= limit) == (limit > exact.upper));
  }
}

TEST_CASE("area: a decided share is narrow at last, as often as a busy machine has too little time for it") {
  const Mesh a = shapes::sphere(6, 1.1, {0.1, 0.05, 0}), b = shapes::sphere(5);
  for (const double limit : {0.01, 0.99}) {
    Options options;
    options.direction = Direction::a_to_b;
    options.areas.emplace().beyond = {{0.15, limit}};
    const auto share = [&] {
      const auto deadline = Control::Clock::now() + std::chrono::seconds(60);
      Control control(deadline);
      const AreaBounds found = *measure(a, b, options, control).areas->a_to_b;
      CHECK(control.deadline() == deadline);
      CHECK(found.stop == AreaStop::complete);
      return found.beyond[0];
    };
    const auto width = [](const AreaInterval& of) { return of.upper - of.lower; };
    const AreaInterval decided = share();
    CHECK(width(decided) > 0.1 * decided.upper);
    options.narrow = true;
    AreaInterval narrow = share();
    while (width(narrow) > 0.1 * narrow.upper) narrow = share();
    CHECK(narrow.lower >= decided.lower);
    CHECK(narrow.upper <= decided.upper);
  }
}

TEST_CASE("area: the same bits for any number of threads and every instruction set") {
  const Mesh a = shapes::sphere(6, 1.1, {0.1, 0.05, 0}), b = shapes::sphere(5);
  AreaOptions asked = everything({0.05, 0.15});
  asked.share_tolerance = 1e-2;
  asked.length_tolerance = 3e-2;
  const AreaBounds one = from_a(a, b, asked);
  CHECK(one.stop == AreaStop::complete);
  for (const unsigned threads : {2U, 5U}) CHECK(same(one, from_a(a, b, asked, threads)));
  for (const std::string_view simd : supported_simd()) {
    Options options;
    options.direction = Direction::a_to_b;
    options.areas = asked;
    options.simd = simd;
    Control control;
    CHECK(same(one, *measure(a, b, options, control).areas->a_to_b));
  }
}

TEST_CASE("area: triangles refined as a sample of them was: the same intervals, narrow enough, on any threads") {
  const Mesh a = shapes::sphere(6, 1.1, {0.1, 0.05, 0}), b = shapes::sphere(5);
  AreaOptions asked = everything({0.05, 0.15});
  asked.share_tolerance = asked.length_tolerance = 2e-2;
  const AreaBounds plain = from_a(a, b, asked);
  const auto meet = [](const AreaInterval& x, const AreaInterval& y) {
    return x.lower <= y.upper && y.lower <= x.upper;
  };
  for (const std::size_t sample : {std::size_t{1}, std::size_t{9}}) {
    CAPTURE(sample);
    Options options;
    options.direction = Direction::a_to_b;
    options.areas = asked;
    options.thresholds.area_sample = sample;
    std::vector<AreaBounds> found;
    for (const unsigned threads : {1U, 3U}) {
      options.threads = threads;
      Control control;
      found.push_back(*measure(a, b, options, control).areas->a_to_b);
    }
    CHECK(same(found[0], found[1]));
    CHECK(found[0].stop == AreaStop::complete);
    for (std::size_t k = 0; k < 2; ++k) CHECK(meet(found[0].beyond[k], plain.beyond[k]));
    for (std::size_t q = 0; q < plain.quantiles.size(); ++q) CHECK(meet(found[0].quantiles[q], plain.quantiles[q]));
    CHECK(meet(*found[0].mean, *plain.mean));
    CHECK(meet(*found[0].rms, *plain.rms));
  }
}

TEST_CASE("area: quantiles alone of scattered triangles are narrow enough, with a sample") {
  std::mt19937_64 random(1);
  std::exponential_distribution<double> height;
  std::uniform_real_distribution<double> bump(0, 0.2);
  Mesh b = shapes::moved(shapes::scaled(shapes::grid(40), 3), {-1, -1, 0});
  for (Vec3& p : b.positions) p.z() -= bump(random);
  AreaOptions asked;
  asked.quantiles = {0.9497};  // within a triangle
  for (int round = 0; round < 8; ++round) {
    CAPTURE(round);
    Mesh a;
    for (std::uint32_t i = 0; i < 1600; ++i) {
      const double x = i % 40 / 40.0, y = i / 40 / 40.0, z = height(random);
      for (const Vec3& corner : {Vec3(x, y, z), Vec3(x + 0.01, y, z), Vec3(x, y + 0.01, z)})
        a.positions.push_back(corner);
      a.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    Options options;
    options.direction = Direction::a_to_b;
    options.areas = asked;
    options.thresholds.area_sample = 100;
    Control control;
    const AreaBounds found = *measure(a, b, options, control).areas->a_to_b;
    CHECK(found.stop == AreaStop::complete);
    CHECK(found.quantiles[0].upper - found.quantiles[0].lower <= asked.length_tolerance * found.quantiles[0].upper);
  }
}

TEST_CASE("area: few work items leave the triangles' own bounds, also with a sample") {
  const Mesh a = shapes::sphere(6, 1.1, {0.1, 0.05, 0}), b = shapes::sphere(5);
  Options options;
  options.direction = Direction::a_to_b;
  options.areas = everything({});
  options.areas->length_tolerance = 1e-3;
  options.max_work_items = 1000;
  options.thresholds.area_sample = 64;
  Control control;
  const Outcome found = measure(a, b, options, control);
  const AreaBounds& bounds = *found.areas->a_to_b;
  CHECK(bounds.stop == AreaStop::budget);
  CHECK(bounds.mean->lower > 0);
  CHECK(bounds.mean->upper < found.upper);
}

TEST_CASE("area: an interruption at any check leaves intervals that hold") {
  const Mesh a = shapes::sphere(5, 1.1, {0.1, 0.05, 0}), b = shapes::sphere(4);
  AreaOptions shares;
  shares.beyond = {{0.05, {}}, {0.15, {}}};
  for (AreaOptions asked : {everything({0.05, 0.15}), shares}) {
    CAPTURE(asked.mean);
    asked.share_tolerance = asked.length_tolerance = 5e-2;
    Control whole;
    const Outcome exact = measured(a, b, asked, whole);
    const AreaBounds& narrow = *exact.areas->a_to_b;
    REQUIRE(narrow.stop == AreaStop::complete);
    const auto meet = [](const AreaInterval& x, const AreaInterval& y) {
      return x.lower <= y.upper && y.lower <= x.upper && x.lower <= x.upper;
    };
    bool was_interrupted = false, by_sample = false;
    for (std::uint64_t at = 1; at <= whole.checks(); at += 1 + whole.checks() / 40) {
      CAPTURE(at);
      Control control;
      control.cancel_at_check(at);
      Options options;
      options.direction = Direction::a_to_b;
      options.areas = asked;
      options.thresholds.area_sample = by_sample ? 9 : 0;
      by_sample = !by_sample;
      const AreaBounds found = *measure(a, b, options, control).areas->a_to_b;
      was_interrupted = was_interrupted || found.stop == AreaStop::cancelled;
      for (std::size_t k = 0; k < 2; ++k) CHECK(meet(found.beyond[k], narrow.beyond[k]));
      for (std::size_t q = 0; q < asked.quantiles.size(); ++q) CHECK(meet(found.quantiles[q], narrow.quantiles[q]));
      if (asked.mean) CHECK(meet(*found.mean, *narrow.mean));
      if (asked.mean) CHECK(meet(*found.rms, *narrow.rms));
    }
    CHECK(was_interrupted);
  }
}

TEST_CASE("area: sampled estimates meet the intervals within four of their standard errors") {
  const Mesh a = shapes::sphere(6, 1.2, {0.1, 0.05, 0}), b = shapes::sphere(8);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    CAPTURE(seed);
    Options options;
    options.areas = everything({});
    options.statistics = Sampling{20'000, seed};
    Control control;
    const Outcome found = measure(a, b, options, control);
    for (const auto& [certified, sampled] : {std::pair(found.areas->a_to_b, found.statistics->a_to_b),
                                             std::pair(found.areas->b_to_a, found.statistics->b_to_a)}) {
      const auto meets = [](const AreaInterval& interval, const Estimate& estimate) {
        return holds(interval, estimate.value, 4 * estimate.standard_error);
      };
      CHECK(meets(*certified->mean, sampled->mean));
      CHECK(meets(*certified->rms, sampled->rms));
      CHECK(meets(certified->quantiles[0], sampled->p50));
      CHECK(meets(certified->quantiles[1], sampled->p95));
      CHECK(meets(certified->quantiles[2], sampled->p99));
    }
  }
}

TEST_CASE("area: the interval of the distance does not depend on it") {
  const Mesh a = shapes::sphere(6, 1.1), b = shapes::sphere(5);
  Options options;
  Control control;
  const Outcome plain = measure(a, b, options, control);
  options.areas = everything({0.05});
  options.areas->share_tolerance = options.areas->length_tolerance = 0.1;
  const Outcome with = measure(a, b, options, control);
  CHECK(same_bits(plain.lower, with.lower));
  CHECK(same_bits(plain.upper, with.upper));
  CHECK(with.areas->b_to_a);
}

TEST_CASE("area: of equal meshes nothing is beyond 0") {
  const AreaBounds found = from_a(tilted(), tilted(), everything({0}));
  CHECK(found.stop == AreaStop::complete);
  CHECK(found.beyond[0].upper == 0);
  CHECK(found.quantiles[2].upper == 0);
  CHECK(found.rms->upper == 0);
}

TEST_CASE("area: the certified bound of all distances decides a limit of the same value") {
  const Mesh a = shapes::moved(plane(), {0, 0, 0.1});
  Control control;
  const double upper = measured(a, plane(), everything({1}), control).a_to_b->bounds.upper;
  CHECK(from_a(a, plane(), everything({upper})).beyond[0].upper == 0);
}

TEST_CASE("area: a share leaves open what the input error does") {
  const Mesh a = shapes::moved(shapes::grid(20), {0, 0, 0.1});
  Options options;
  options.direction = Direction::a_to_b;
  for (const double limit : {0.095, 0.105}) {
    CAPTURE(limit);
    options.areas.emplace().beyond = {{limit, {}}};
    Control control;
    const auto moved = [](const Mesh& mesh) {
      return Prepared(mesh, Prepared::Use::once, nullptr, std::nullopt, 0.004);
    };
    const AreaBounds found = *measure(moved(a), moved(plane()), options, control).areas->a_to_b;
    CHECK(found.beyond[0].lower == 0);
    CHECK(found.beyond[0].upper == 1);
  }
}

TEST_CASE("area: where rounding may have moved a surface farther than it is wide, nothing is said of its areas") {
  const Mesh a{{{1e17, 1e17, 1e17}, {1e17, 1e17, 1e17}, {1e17, 1e17, 1e17}}, {{0, 1, 2}}};
  Options options;
  options.areas = everything({10});
  Control control;
  const auto moved = [&a] { return Prepared(a, Prepared::Use::once, nullptr, std::nullopt, 1000); };
  const Outcome outcome = measure(moved(), moved(), options, control);
  const AreaBounds& found = outcome.areas->a_to_b.value();
  REQUIRE(outcome.a_to_b->bounds.upper >= 2000);  // the exact surfaces may be so far apart
  CHECK(found.stop == AreaStop::precision_floor);
  CHECK(found.beyond[0].upper == 1);
  CHECK(found.quantiles[0].upper >= 2000);
  CHECK(found.mean->upper >= 2000);
}

TEST_CASE("area: intervals hold with little memory and few work items") {
  const Mesh a = shapes::sphere(12), b = shapes::cube();
  const AreaBounds whole = from_a(a, b, everything({0.25}));
  REQUIRE(whole.stop == AreaStop::complete);
  const auto meets = [](const AreaInterval& x, const AreaInterval& y) {
    return x.lower <= y.upper && y.lower <= x.upper && x.upper - x.lower >= y.upper - y.lower;
  };
  constexpr std::size_t kPlenty = std::size_t{1} << 29;
  for (const auto& [memory, items] :
       {std::pair<std::size_t, std::size_t>{1, kPlenty}, {150'000, kPlenty}, {kPlenty, 5}}) {
    Options options;
    options.direction = Direction::a_to_b;
    options.areas = everything({0.25});
    options.max_memory_bytes = memory;
    options.max_work_items = items;
    Control control;
    const AreaBounds found = measure(a, b, options, control).areas->a_to_b.value();
    CHECK(found.stop == AreaStop::budget);
    CHECK(meets(found.beyond[0], whole.beyond[0]));
    CHECK(meets(found.quantiles[1], whole.quantiles[1]));
    CHECK(meets(*found.mean, *whole.mean));
    options.areas->quantiles.clear();
    options.areas->mean = false;
    const AreaBounds share = measure(a, b, options, control).areas->a_to_b.value();
    CHECK(meets(share.beyond[0], whole.beyond[0]));
  }
}
