// Micro-benchmarks of the engine (Google Benchmark): ./dev bench micro [--benchmark_filter=REGEX ...]
//
//   kernel_*/SET   the kernels of one instruction set: eight triangles prepared; a cold query among 100,000
//   build/N        the tree over N triangles
//   nearest_*/N    one closest-point query in a tree of N: `cold` in random order without a hint, `hinted` along a
//                  walk over the surface, where each query starts from the triangle that the last one found
//   distance_*     one computed distance: a point or a triangle from a triangle each by itself
//   measure_*/N    measure() on N against N triangles at 1e-4 of the diagonal: `near` two meshes of one shape,
//                  `same` a mesh against itself, `far` two that do not touch; counts the memory held beside them
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "counted_memory.h"
#include "engine/hausdorff.h"
#include "engine/paper/triangle_set.h"
#include "engine/tree/bvh.h"
#include "engine/tree/nearest.h"
#include "engine/tree/ordered_mesh.h"
#include "shapes.h"

namespace {

using namespace meshgauge;

// About n triangles: a sphere of unit radius with bumps; `phase` turns the bumps, so that two phases are near, but not
// the same.
Mesh bumpy(std::int64_t n, double phase = 0) {
  const auto rings = static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(n) / 4)));
  Mesh mesh = shapes::scaled(shapes::sphere(rings), 0.9);  // in the unit frame, as Bvh requires
  for (Vec3& p : mesh.positions) {
    p *= 1 + 0.05 * std::sin(7 * p.x() + phase) * std::cos(5 * p.y()) * std::sin(6 * p.z() + phase);
  }
  return mesh;
}

// A mesh in the engine's order, with its tree.
struct Ordered {
  Control control;
  ThreadPool pool{1};
  OrderedMesh mesh;
  Bvh tree;
  explicit Ordered(const Mesh& given)
      : mesh(given, {}, bounding_box(given), Frame(bounding_box(given)), control, pool),
        tree(mesh.view(), *find_kernels("auto"), control, pool) {}
};

void per_triangle(benchmark::State& state, std::size_t triangles) {
  state.counters["triangles"] = static_cast<double>(triangles);
  state.counters["per_triangle"] = benchmark::Counter(
      static_cast<double>(triangles), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void build(benchmark::State& state) {
  const Mesh mesh = bumpy(state.range(0));
  Control control;
  ThreadPool pool(1);
  const Box box = bounding_box(mesh);
  for (auto _ : state) {
    const OrderedMesh ordered(mesh, {}, box, Frame(box), control, pool);
    const Bvh tree(ordered.view(), *find_kernels("auto"), control, pool);
    benchmark::DoNotOptimize(&tree);
  }
  per_triangle(state, mesh.triangles.size());
}

// Points near the surface: its vertices, moved by up to 1 % of the radius.
std::vector<Vec3> queries_near(const Mesh& mesh, std::size_t count) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> vertex(0, mesh.positions.size() - 1);
  std::uniform_real_distribution<double> offset(-0.01, 0.01);
  std::vector<Vec3> points;
  while (points.size() < count) {
    points.push_back(mesh.positions[vertex(random)] + Vec3(offset(random), offset(random), offset(random)));
  }
  return points;
}

void nearest_cold(benchmark::State& state) {
  const Mesh mesh = bumpy(state.range(0));
  const Ordered ordered(mesh);
  const Bvh& tree = ordered.tree;
  const std::vector<Vec3> points = queries_near(mesh, 1 << 14);
  std::uint64_t tests = 0, done = 0;
  for (auto _ : state) benchmark::DoNotOptimize(nearest(tree, points[done++ % points.size()], tests));
  state.counters["triangle_tests"] = static_cast<double>(tests) / static_cast<double>(done);
}

void nearest_hinted(benchmark::State& state) {
  const Mesh mesh = bumpy(state.range(0));
  const Mesh other = bumpy(state.range(0), 0.1);  // its vertices are in rings: a walk
  const Ordered ordered(mesh);
  const Bvh& tree = ordered.tree;
  std::uint64_t tests = 0, done = 0;
  std::uint32_t hint = Nearest::kNone;
  for (auto _ : state) {
    const Nearest found = nearest(tree, other.positions[done++ % other.positions.size()], tests, hint);
    hint = found.slot;
    benchmark::DoNotOptimize(found);
  }
  state.counters["triangle_tests"] = static_cast<double>(tests) / static_cast<double>(done);
}

void measure_pair(benchmark::State& state, const Mesh& a, const Mesh& b) {
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {std::nullopt, 1e-4, std::nullopt};
  const std::size_t meshes = bench::held_bytes();
  bench::reset_peak();
  Stop stop = Stop::converged;
  for (auto _ : state) {
    Control control;
    stop = measure(a, b, options, control).stop;
  }
  if (stop != Stop::converged && stop != Stop::precision_floor) state.SkipWithError("did not converge");
  const std::size_t triangles = a.triangles.size() + b.triangles.size();
  per_triangle(state, triangles);
  state.counters["bytes_per_triangle"] =
      static_cast<double>(bench::peak_bytes() - meshes) / static_cast<double>(triangles);
}

void measure_near(benchmark::State& state) { measure_pair(state, bumpy(state.range(0)), bumpy(state.range(0), 0.1)); }

void measure_same(benchmark::State& state) {
  const Mesh mesh = bumpy(state.range(0));
  measure_pair(state, mesh, mesh);
}

void measure_far(benchmark::State& state) {
  measure_pair(state, bumpy(state.range(0)), shapes::moved(bumpy(state.range(0)), {5, 0, 0}));
}

// The kernels of one instruction set.
void kernel_prepare(benchmark::State& state, const Kernels* kernels) {
  std::array<PointBlock, 3> corners;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (PointBlock& block : corners) {
    for (auto& axis : block.at) std::generate(std::begin(axis), std::end(axis), [&] { return uniform(random); });
  }
  TriangleBlock out;
  for (auto _ : state) benchmark::DoNotOptimize(kernels->prepare(corners.data(), out));
  state.counters["per_triangle"] =
      benchmark::Counter(kLanes, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void kernel_nearest(benchmark::State& state, const Kernels* kernels) {
  const Mesh mesh = bumpy(100'000);
  const Ordered ordered(mesh);
  const std::vector<Vec3> points = queries_near(mesh, 1 << 14);
  std::uint64_t tests = 0, done = 0;
  Polling never;
  for (auto _ : state) {
    const Closest start{std::numeric_limits<double>::infinity(), Nearest::kNone};
    benchmark::DoNotOptimize(
        kernels->nearest(ordered.tree.view(), points[done++ % points.size()].data(), start, tests, never));
  }
  state.counters["triangle_tests"] = static_cast<double>(tests) / static_cast<double>(done);
}

// Triangles of the size of a mesh's, at distances like those of two meshes that are near.
std::vector<CornersAndFrame> small_triangles(double height, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-0.1, 0.1), size(-0.02, 0.02);
  std::vector<CornersAndFrame> triangles;
  for (int i = 0; i < 1 << 10; ++i) {
    const Vec3 at(place(random), place(random), height + 0.1 * place(random));
    const auto corner = [&] { return Vec3(at + Vec3(size(random), size(random), 0.2 * size(random))); };
    const Vec3 a = corner(), b = corner(), c = corner();
    triangles.push_back({{a, b, c}, prepare(a, b, c).triangle});
  }
  return triangles;
}

void distance_point_triangle(benchmark::State& state) {
  const auto from = small_triangles(0, 1), to = small_triangles(0.05, 2);
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t k = i++;
    benchmark::DoNotOptimize(distance(to[k % to.size()].prepared, from[(7 * k) % from.size()].corners[0]));
  }
}

void distance_triangle_triangle(benchmark::State& state) {
  const auto from = small_triangles(0, 1), to = small_triangles(0.05, 2);
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t k = i++;
    benchmark::DoNotOptimize(triangle_distance(from[(7 * k) % from.size()], to[k % to.size()]));
  }
}

// Sizes from 1e3 to `most` triangles.
void sizes(benchmark::internal::Benchmark* benchmark, std::int64_t most) {
  benchmark->RangeMultiplier(10)->Range(1'000, most)->Unit(benchmark::kMicrosecond)->UseRealTime();
}

BENCHMARK(build)->Apply([](auto* b) { sizes(b, 1'000'000); });
BENCHMARK(distance_point_triangle);
BENCHMARK(distance_triangle_triangle);
BENCHMARK(nearest_cold)->RangeMultiplier(10)->Range(1'000, 1'000'000);
BENCHMARK(nearest_hinted)->RangeMultiplier(10)->Range(1'000, 1'000'000);
BENCHMARK(measure_near)->Apply([](auto* b) { sizes(b, 1'000'000); });
BENCHMARK(measure_same)->Apply([](auto* b) { sizes(b, 1'000'000); });
BENCHMARK(measure_far)->Apply([](auto* b) { sizes(b, 1'000'000); });

}  // namespace

int main(int argc, char** argv) {
  for (const Kernels& kernels : supported_kernels()) {
    const std::string name = kernels.name;
    benchmark::RegisterBenchmark(("kernel_prepare/" + name).c_str(), kernel_prepare, &kernels);
    benchmark::RegisterBenchmark(("kernel_nearest/" + name).c_str(), kernel_nearest, &kernels);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
