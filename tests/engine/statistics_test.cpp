// The estimators against values computed by hand, and sampled statistics of measure() for shapes whose statistics are
// known.
#include "engine/statistics.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <string>
#include <vector>

#include "engine/extras/statistics/statistics_stage.h"
#include "engine/hausdorff.h"
#include "engine/tree/triangle.h"
#include "same_outcome.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

Outcome sampled(const Mesh& a, const Mesh& b, const Sampling& sampling, Direction direction = Direction::a_to_b,
                unsigned threads = 1) {
  Options options;
  options.direction = direction;
  options.threads = threads;
  options.statistics = sampling;
  Control control;
  return measure(a, b, options, control);
}

Distribution from_a(const Mesh& a, const Mesh& b, const Sampling& sampling) {
  return sampled(a, b, sampling).statistics.value().a_to_b.value();
}

bool same(const Estimate& a, const Estimate& b) {
  return same_bits(a.value, b.value) && same_bits(a.standard_error, b.standard_error);
}

bool same(const std::optional<Distribution>& a, const std::optional<Distribution>& b) {
  if (!a || !b) return !a && !b;
  return a->weight == b->weight && a->samples == b->samples && same(a->mean, b->mean) && same(a->rms, b->rms) &&
         same(a->p50, b->p50) && same(a->p95, b->p95) && same(a->p99, b->p99) && same_bits(a->max_seen, b->max_seen) &&
         std::equal(a->histogram.begin(), a->histogram.end(), b->histogram.begin(),
                    [](const Estimate& x, const Estimate& y) { return same(x, y); });
}

// The true values.
struct Truth {
  double mean, rms, p50, p95, p99;
};

constexpr Estimate Distribution::*kEstimates[] = {&Distribution::mean, &Distribution::rms, &Distribution::p50,
                                                  &Distribution::p95, &Distribution::p99};
constexpr double Truth::*kTruths[] = {&Truth::mean, &Truth::rms, &Truth::p50, &Truth::p95, &Truth::p99};
const std::string kNames[] = {"mean", "rms", "p50", "p95", "p99"};

// Checks over many seeds that every estimate is within 4 standard errors of the true value, and about 95 % of them
// within 1.96. Of 200 normal ones 95 % +- 1.5 % are. `accuracy`: of the true values.
void agree(const Mesh& a, const Mesh& b, const Truth& truth, std::size_t samples, double accuracy = 0) {
  constexpr std::uint64_t kSeeds = 200;
  std::vector<Distribution> found;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) found.push_back(from_a(a, b, {samples, seed}));
  for (std::size_t e = 0; e < std::size(kEstimates); ++e) {
    const double exact = truth.*kTruths[e];
    int within = 0;
    double worst = 0;
    for (const Distribution& one : found) {
      const Estimate& estimate = one.*kEstimates[e];
      const double off = std::max(std::abs(estimate.value - exact) - accuracy, 0.0) / estimate.standard_error;
      within += off <= 1.96 ? 1 : 0;
      worst = std::max(worst, off);
    }
    MESSAGE(kNames[e], ": within 1.96 standard errors ", within, " of ", kSeeds, ", worst ", worst);
    CHECK(worst < 4);
    CHECK(within >= 0.90 * kSeeds);
    CHECK(within <= 0.99 * kSeeds);
  }
}

const Mesh kFloor = shapes::moved(shapes::grid(1, 20), Vec3(-10, -10, 0));

Mesh icosahedron(double radius) {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  Mesh mesh;
  for (const double s : {-1.0, 1.0}) {
    for (const double g : {-golden, golden}) {
      mesh.positions.insert(mesh.positions.end(), {{0, s, g}, {s, g, 0}, {g, 0, s}});
    }
  }
  for (Vec3& p : mesh.positions) p *= radius / std::hypot(1, golden);
  // The faces are the triples whose sides are all edges.
  const double edge = 2 * radius / std::hypot(1, golden);
  const auto joined = [&](std::uint32_t i, std::uint32_t j) {
    return std::abs((mesh.positions[i] - mesh.positions[j]).norm() - edge) < 1e-9 * radius;
  };
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::uint32_t j = i + 1; j < 12; ++j) {
      for (std::uint32_t k = j + 1; k < 12; ++k) {
        if (joined(i, j) && joined(j, k) && joined(i, k)) mesh.triangles.push_back({i, j, k});
      }
    }
  }
  return mesh;
}

// Quadrature at the middles of the edges of the n * n parts of one face, which is exact for quadratics; the other faces
// are alike. Quantiles use the centroids.
Truth integrated(const Mesh& from, const Mesh& to, int n) {
  std::vector<PreparedTriangle> triangles;
  for (std::size_t t = 0; t < to.triangles.size(); ++t) {
    const MeshView view(to);
    triangles.push_back(prepare(view.corner(t, 0), view.corner(t, 1), view.corner(t, 2)).triangle);
  }
  const Vec3& a = MeshView(from).corner(0, 0);
  const Vec3 u = (MeshView(from).corner(0, 1) - a) / n, v = (MeshView(from).corner(0, 2) - a) / n;
  const auto distance = [&](double i, double j) {
    const Vec3 p = a + i * u + j * v;
    double best = 1e300;
    for (const PreparedTriangle& t : triangles) best = std::min(best, (p - closest_point(t, p)).norm());
    return best;
  };
  double sum = 0, squares = 0;
  std::vector<double> centroids;
  const auto add = [&](double i, double j, double side) {  // the part with corners (i,j), (i+side,j), (i,j+side)
    for (const double d :
         {distance(i + side / 2, j), distance(i, j + side / 2), distance(i + side / 2, j + side / 2)}) {
      sum += d;
      squares += d * d;
    }
    centroids.push_back(distance(i + side / 3, j + side / 3));
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i + j < n; ++i) {
      add(i, j, 1);
      if (i + j + 1 < n) add(i + 1, j + 1, -1);
    }
  }
  std::sort(centroids.begin(), centroids.end());
  const double count = static_cast<double>(centroids.size());
  const auto quantile = [&](double share) { return centroids[static_cast<std::size_t>(share * count)]; };
  return {sum / (3 * count), std::sqrt(squares / (3 * count)), quantile(0.50), quantile(0.95), quantile(0.99)};
}

}  // namespace

TEST_CASE("the estimators agree with values computed by hand") {
  // Two strata: nine times 0 and a 2; half 4, half 6. Their means are 0.2 and 5.
  std::vector<double> values(20, 0);
  values[9] = 2;
  for (std::size_t i = 10; i < 20; ++i) values[i] = i % 2 == 0 ? 4 : 6;
  const Distribution found = summarize(values);
  CHECK(found.samples == 20);
  CHECK(found.mean.value == doctest::Approx(2.6));
  CHECK(found.mean.standard_error == doctest::Approx(std::sqrt((9 * 0.04 + 1.8 * 1.8 + 10) * 10 / 9) / 20));
  CHECK(found.rms.value == doctest::Approx(std::sqrt(13.2)));  // squares: 0.4 and 26 in the mean
  const double of_square = std::sqrt((9 * 0.16 + 3.6 * 3.6 + 10 * 100) * 10 / 9) / 20;
  CHECK(found.rms.standard_error == doctest::Approx(of_square / (2 * std::sqrt(13.2))));
  // All values of one stratum and none of the other are at most 2: one rank, two errors to each side: 0 and 4.
  CHECK(found.p50.value == 2);
  CHECK(found.p50.standard_error == 1);
  CHECK(found.p99.value == 6);
  CHECK(found.max_seen == 6);
  CHECK(found.histogram.front().value == 0.45);
  CHECK(found.histogram.front().standard_error == doctest::Approx(std::sqrt(9.0 / 9 + 1) / 20));
  CHECK(found.histogram[10].value == 0.05);  // 2 of 0 .. 6
  CHECK(found.histogram.back().value == 0.25);
  CHECK(found.histogram.back().standard_error == doctest::Approx(std::sqrt(25.0 / 9 + 1) / 20));
}

TEST_CASE("equal values have no error, and their mean is not above them") {
  for (const double x : {0.0, 0.1, 1e-300}) {
    const Distribution found = summarize(std::vector<double>(1010, x));
    for (const auto estimate :
         {&Distribution::mean, &Distribution::rms, &Distribution::p50, &Distribution::p95, &Distribution::p99}) {
      CHECK((found.*estimate).value == doctest::Approx(x).epsilon(1e-12));
      CHECK((found.*estimate).value <= x);
      CHECK((found.*estimate).standard_error == 0);
    }
    CHECK(found.max_seen == x);
    CHECK(found.histogram[x == 0 ? 0 : Distribution::kBins - 1].value == 1);
  }
}

TEST_CASE("statistics: a tilted patch above a plane has uniform distances from 0 to 1") {
  const Mesh patch{{{0, 0, 0}, {2, 0, 1}, {2, 3, 1}, {0, 3, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  agree(patch, kFloor, {0.5, std::sqrt(1.0 / 3), 0.50, 0.95, 0.99}, 2000);
}

TEST_CASE("statistics: the same patch in many slivers of very different sizes") {
  Mesh patch;
  for (int i = 0; i <= 60; ++i) {
    const double x = std::pow(i / 60.0, 3);
    patch.positions.insert(patch.positions.end(), {{2 * x, 0, x}, {2 * x, 3, x}});
  }
  for (std::uint32_t i = 0; i < 120; i += 2) {
    patch.triangles.insert(patch.triangles.end(), {{i, i + 2, i + 3}, {i, i + 3, i + 1}});
  }
  agree(patch, kFloor, {0.5, std::sqrt(1.0 / 3), 0.50, 0.95, 0.99}, 2000);
}

TEST_CASE("statistics: a square and the point in its middle") {
  const Mesh square = shapes::moved(shapes::grid(3), Vec3(-0.5, -0.5, 0));
  const Mesh point = shapes::triangle(Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
  // Within r < 1/2 lies the area pi r^2. Beyond that lie the corners: 1 - pi r^2 + 4 (r^2 acos(1/(2r)) - sqrt(r^2 -
  // 1/4) / 2), solved for 5 % and 1 % by bisection.
  const auto beyond = [](double r) {
    const double cap = r * r * std::acos(0.5 / r) - 0.5 * std::sqrt(r * r - 0.25);
    return 1 - std::acos(-1.0) * r * r + 4 * cap;
  };
  const auto radius = [&](double share) {
    double low = 0.5, high = std::sqrt(0.5);
    for (int i = 0; i < 60; ++i) (beyond((low + high) / 2) > share ? low : high) = (low + high) / 2;
    return low;
  };
  const double mean = (std::sqrt(2.0) + std::asinh(1.0)) / 6;
  agree(square, point, {mean, std::sqrt(1.0 / 6), std::sqrt(0.5 / std::acos(-1.0)), radius(0.05), radius(0.01)}, 2000);
  const Distribution back = from_a(point, square, {1000, 1});
  CHECK(back.weight == Weight::points);
  CHECK(back.max_seen == 0);
}

TEST_CASE("statistics: of a cloud each point counts, once and without an error") {
  Mesh cloud;
  for (int i = 1; i <= 1234; ++i) cloud.positions.emplace_back(0.5, 0.5, i / 1234.0);
  cloud.triangles = points_as_triangles(cloud.positions.size());
  const Distribution found = from_a(cloud, kFloor, {1000, 1});
  CHECK(found.weight == Weight::points);
  CHECK(found.samples == 1234);
  CHECK(found.mean.value == doctest::Approx(1235 / (2 * 1234.0)).epsilon(1e-13));
  CHECK(found.rms.value == doctest::Approx(std::sqrt(1235 * 2469 / 6.0) / 1234).epsilon(1e-13));
  CHECK(found.p50.value == doctest::Approx(617 / 1234.0).epsilon(1e-13));
  CHECK(found.p95.value == doctest::Approx(1173 / 1234.0).epsilon(1e-13));
  CHECK(found.max_seen == doctest::Approx(1).epsilon(1e-13));
  for (const auto estimate : kEstimates) CHECK((found.*estimate).standard_error == 0);
  for (const Estimate& bin : found.histogram) CHECK((bin.value > 0 && bin.standard_error == 0));
  cloud.positions.resize(1);
  cloud.triangles = points_as_triangles(1);
  CHECK(from_a(cloud, kFloor, {1000, 1}).samples == 1);
}

TEST_CASE("statistics: a segment that leaves a plane has uniform distances from 0 to 1, by length") {
  const Mesh segment = shapes::triangle({0, 0, 0}, {0, 0, 0.3}, {0, 0, 1});
  const Distribution found = from_a(segment, kFloor, {10'000, 1});
  CHECK(found.weight == Weight::length);
  CHECK(found.mean.value == doctest::Approx(0.5).epsilon(1e-4));
  CHECK(found.rms.value == doctest::Approx(std::sqrt(1.0 / 3)).epsilon(1e-4));
  CHECK(found.p95.value == doctest::Approx(0.95).epsilon(1e-3));
  for (const Estimate& bin : found.histogram) CHECK(std::abs(bin.value - 1.0 / 32) <= 4 * bin.standard_error);
}

TEST_CASE("statistics: parallel squares have one distance everywhere") {
  const Distribution found = from_a(shapes::grid(5, 1, 0.3), kFloor, {1000, 1});
  for (const auto estimate : kEstimates) {
    CHECK((found.*estimate).value == doctest::Approx(0.3).epsilon(1e-13));
    CHECK((found.*estimate).standard_error < 1e-13);
  }
}

TEST_CASE("statistics: two concentric icosahedra agree with quadrature") {
  const Mesh outer = icosahedron(1.5), inner = icosahedron(1);
  REQUIRE(outer.triangles.size() == 20);
  const Truth coarse = integrated(outer, inner, 150), fine = integrated(outer, inner, 300);
  CHECK(coarse.mean == doctest::Approx(fine.mean).epsilon(1e-7));
  CHECK(coarse.rms == doctest::Approx(fine.rms).epsilon(1e-7));
  agree(outer, inner, fine, 2000, 2e-5);
  const Distribution many = from_a(outer, inner, {1'000'000, 1});
  CHECK(many.mean.standard_error < 1e-6);
  CHECK(std::abs(many.mean.value - fine.mean) <= 4 * many.mean.standard_error + 1e-7);
  CHECK(std::abs(many.rms.value - fine.rms) <= 4 * many.rms.standard_error + 1e-7);
  MESSAGE("quadrature: mean ", fine.mean, ", rms ", fine.rms, "; a million samples: ", many.mean.value, " +- ",
          many.mean.standard_error, ", ", many.rms.value, " +- ", many.rms.standard_error);
}

TEST_CASE("statistics: no sample exceeds the upper bound, up to rounding") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 40; ++i) {
    const Mesh a = shapes::soup(20, random), b = shapes::soup(20, random);
    Control control;
    ThreadPool pool(1);
    Box box = bounding_box(a);
    box.extend(bounding_box(b));
    const Frame frame(box);
    const Prepared from(a), to(b);
    const Outcome outcome = sampled(a, b, {1000, 1});
    const auto framed_from = from.in(frame, *find_kernels("auto")), framed_to = to.in(frame, *find_kernels("auto"));
    const auto found = sample_distances({*framed_from, *framed_to, {1000, 1}, 0, pool, control, [] {}});
    REQUIRE(found.has_value());
    const double largest = *std::max_element(found->values.begin(), found->values.end());
    CHECK(std::ldexp(largest, frame.exponent()) <= outcome.upper * (1 + 1e-14));
    CHECK(outcome.statistics->a_to_b->max_seen <= outcome.upper);
    CHECK(outcome.statistics->a_to_b->max_seen ==
          doctest::Approx(std::ldexp(largest, frame.exponent())).epsilon(1e-14));
  }
}

TEST_CASE("statistics: each direction has its own points") {
  const Mesh small = shapes::grid(4), large = shapes::moved(shapes::grid(4, 2), Vec3(0, 0, 0.25));
  const Statistics found = sampled(small, large, {1000, 1}, Direction::symmetric).statistics.value();
  CHECK(found.status == StatisticsStatus::complete);
  CHECK(found.a_to_b->mean.value == doctest::Approx(0.25));
  CHECK(found.b_to_a->mean.value > 0.3);  // three quarters of it lie outside the small one
  CHECK(!sampled(small, large, {1000, 1}, Direction::a_to_b).statistics->b_to_a);
  const Statistics back = sampled(small, large, {1000, 1}, Direction::b_to_a).statistics.value();
  CHECK(!back.a_to_b);
  CHECK(same(back.b_to_a, found.b_to_a));
}

TEST_CASE("statistics: the same seed gives the same bits on any number of threads") {
  const Mesh a = shapes::sphere(60), b = shapes::sphere(51, 1.01, Vec3(0.01, 0, 0));
  const Outcome one = sampled(a, b, {5000, 1}, Direction::symmetric);
  for (const unsigned threads : {2U, 4U}) {
    const Outcome outcome = sampled(a, b, {5000, 1}, Direction::symmetric, threads);
    CHECK(same(outcome.statistics->a_to_b, one.statistics->a_to_b));
    CHECK(same(outcome.statistics->b_to_a, one.statistics->b_to_a));
  }
  CHECK(!same(sampled(a, b, {5000, 2}, Direction::symmetric).statistics->a_to_b, one.statistics->a_to_b));
  CHECK(sampled(a, b, {4991, 1}).statistics->a_to_b->samples == 5000);
}

TEST_CASE("statistics: values are in the meshes' unit at any offset and scale") {
  const Mesh a = shapes::sphere(20), b = shapes::sphere(17, 1.02);
  const Distribution unit = from_a(a, b, {2000, 1});
  const Distribution scaled = from_a(shapes::scaled(a, 1024), shapes::scaled(b, 1024), {2000, 1});
  CHECK(same_bits(scaled.mean.value, 1024 * unit.mean.value));
  CHECK(same_bits(scaled.p95.standard_error, 1024 * unit.p95.standard_error));
  CHECK(same_bits(scaled.max_seen, 1024 * unit.max_seen));
  const Vec3 far(1e6, -2e6, 3e6);
  const Distribution moved = from_a(shapes::moved(a, far), shapes::moved(b, far), {2000, 1});
  CHECK(moved.mean.value == doctest::Approx(unit.mean.value).epsilon(1e-3));
  CHECK(moved.rms.value == doctest::Approx(unit.rms.value).epsilon(1e-3));
}

TEST_CASE("statistics: lengths and areas whose squares overflow or underflow") {
  const Mesh a = shapes::sphere(10), b = shapes::sphere(9, 1.02);
  const Distribution unit = from_a(a, b, {1000, 1});
  for (const int exponent : {900, -900}) {
    const double factor = std::ldexp(1.0, exponent);
    const Distribution found = from_a(shapes::scaled(a, factor), shapes::scaled(b, factor), {1000, 1});
    for (const auto estimate : kEstimates) {
      CHECK(same_bits((found.*estimate).value, factor * (unit.*estimate).value));
      CHECK(same_bits((found.*estimate).standard_error, factor * (unit.*estimate).standard_error));
    }
  }
  // In the frame of the large mesh squared lengths of the small mesh underflow.
  const Distribution small = from_a(shapes::scaled(a, 1e-200), b, {1000, 1});
  CHECK(small.weight == Weight::points);
  CHECK(small.mean.value == doctest::Approx(small.max_seen));
}

TEST_CASE("statistics: the interval is the same with and without them") {
  const Mesh a = shapes::sphere(20), b = shapes::sphere(17, 1.02);
  for (const Strategy strategy : {Strategy::automatic, Strategy::four_point}) {
    Options options;
    options.strategy = strategy;
    Control control, watched;
    const Outcome without = measure(a, b, options, control);
    CHECK(!without.statistics);
    options.statistics.emplace();
    CHECK(same_outcome(measure(a, b, options, watched), without));
  }
}

TEST_CASE("statistics: equal meshes give zeros") {
  const Mesh mesh = shapes::sphere(10);
  const Outcome outcome = sampled(mesh, mesh, {1000, 1}, Direction::symmetric);
  CHECK(outcome.upper == 0);
  for (const auto& side : {outcome.statistics->a_to_b, outcome.statistics->b_to_a}) {
    REQUIRE(side.has_value());
    CHECK(side->max_seen == 0);
    CHECK(side->mean.value == 0);
    CHECK(side->histogram[0].value == 1);
  }
}

TEST_CASE("statistics: an interruption leaves no incomplete direction and does not change the interval") {
  const Mesh a = shapes::sphere(20), b = shapes::sphere(17, 1.02);
  Options options;
  Control first;
  const Outcome without = measure(a, b, options, first);
  options.statistics = Sampling{1000, 1};
  Control second;
  const Statistics all = measure(a, b, options, second).statistics.value();
  REQUIRE(second.checks() > first.checks() + 2000);  // one for each point
  for (std::uint64_t n = first.checks() + 1; n < second.checks(); n += 197) {
    Control control;
    control.cancel_at_check(n);
    const Outcome outcome = measure(a, b, options, control);
    CHECK(same_outcome(outcome, without));
    CHECK(outcome.statistics->status == StatisticsStatus::cancelled);
    CHECK(!outcome.statistics->b_to_a);
    if (outcome.statistics->a_to_b) CHECK(same(outcome.statistics->a_to_b, all.a_to_b));
  }
  Control late(Control::Clock::now());
  CHECK(measure(a, b, options, late).statistics->status == StatisticsStatus::timeout);
}

TEST_CASE("statistics: lack of memory in one direction keeps the interval and the other direction") {
  const Mesh a = shapes::sphere(20), b = shapes::sphere(17, 1.02);
  Options options;
  Control first, second;
  const Outcome without = measure(a, b, options, first);
  options.statistics = Sampling{1000, 1};
  int all = 0;
  second.watch([&](const Progress& p) { all += p.stage == std::string("statistics") ? 1 : 0; }, {});
  const Statistics whole = measure(a, b, options, second).statistics.value();
  REQUIRE(all > 2);
  for (const int nth : {1, all}) {
    int seen = 0;
    Control control;
    // A callback must not throw; this one stands for a failed allocation during sampling.
    control.watch(
        [&](const Progress& p) {
          if (p.stage == std::string("statistics") && ++seen == nth) throw std::bad_alloc();
        },
        {});
    const Outcome outcome = measure(a, b, options, control);
    CHECK(same_outcome(outcome, without));
    CHECK(outcome.statistics->status == StatisticsStatus::memory);
    CHECK(outcome.statistics->a_to_b.has_value() == (nth == all));
    if (outcome.statistics->a_to_b) CHECK(same(outcome.statistics->a_to_b, whole.a_to_b));
    CHECK(!outcome.statistics->b_to_a);
  }
}

TEST_CASE("statistics: a kept mesh gives the same statistics again") {
  const Mesh a = shapes::sphere(20), b = shapes::sphere(17, 1.02);
  const Prepared from(a, Prepared::Use::often), to(b, Prepared::Use::often);
  Options options;
  options.statistics = Sampling{1000, 1};
  const auto fresh = sampled(a, b, {1000, 1}, Direction::symmetric).statistics.value();
  for (int i = 0; i < 2; ++i) {
    Control control;
    const auto kept = measure(from, to, options, control).statistics.value();
    CHECK(same(kept.a_to_b, fresh.a_to_b));
    CHECK(same(kept.b_to_a, fresh.b_to_a));
  }
}
