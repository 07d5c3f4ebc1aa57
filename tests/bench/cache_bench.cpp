// What a cached baseline saves: comparisons of a baseline with candidates, each as the first one (nothing is known of
// either mesh) and as the second (the baseline was measured before, with another candidate; this one is new), stage by
// stage, in milliseconds.
//
//   cache_bench [REPETITIONS [BASELINE CANDIDATE...]]
//
// Without files: a bumpy sphere of half a million triangles against coarser ones, one of other vertices, a copy with a
// dent, and a copy far from the origin. The least of all repetitions is shown; one thread.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "api/compare.h"
#include "api/digest.h"
#include "server/jobs/mesh_cache.h"
#include "shapes.h"

namespace {

using namespace meshgauge;
using server::MeshCache;

struct File {
  std::string name;
  std::string bytes;
};

struct Question {
  const char* name;
  Options options;
};

// Bumps at any place, whatever the mesh is made of.
double radius_at(const Vec3& p) {
  return 50 *
         (1 + 0.05 * std::sin(7 * p.x()) * std::cos(9 * p.y()) + 0.02 * std::sin(23 * p.z()) * std::sin(17 * p.x()));
}

Mesh bumpy(std::uint32_t rings, double dent = 0, const Vec3& offset = Vec3::Zero()) {
  Mesh mesh = shapes::sphere(rings);
  for (Vec3& p : mesh.positions) p = offset + p * radius_at(p) * (1 - dent * std::exp(-40 * (1 - p.x())));
  return mesh;
}

std::string to_stl(const Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::string bytes(84 + std::size_t{50} * count, '\0');
  std::memcpy(bytes.data() + 80, &count, sizeof count);
  char* facet = bytes.data() + 84;
  for (std::uint32_t t = 0; t < count; ++t, facet += 50) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3f p = MeshView(mesh).corner(t, i).cast<float>();
      std::memcpy(facet + 12 * (i + 1), p.data(), 12);
    }
  }
  return bytes;
}

File read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty()) std::exit((std::fprintf(stderr, "cannot read %s\n", path.c_str()), 1));
  return {path.substr(path.rfind('/') + 1), std::move(bytes)};
}

api::MeshInput input_of(const char* part, const File& file) {
  return {part, std::as_bytes(std::span(file.bytes)), file.name, ""};
}

struct Bench {
  const File& baseline;
  const std::string baseline_id = api::sha256_hex(std::as_bytes(std::span(baseline.bytes)));

  api::Comparison compare(MeshCache& cache, const File& candidate, const Options& options) const {
    const api::Load load = api::load;
    const api::ReadLimits limits;
    const api::MeshInput a = input_of("a", baseline), b = input_of("b", candidate);
    const api::GetMesh load_a = api::loading(load, a, limits, Prepared::Use::often);
    const auto get_a = [&](Control& control) {
      return cache.get(MeshCache::key("", baseline_id, a.filename, ""), load_a, control);
    };
    Control control;
    auto compared = api::compare_prepared(get_a, api::loading(load, b, limits, Prepared::Use::once), options, control);
    if (!compared) std::exit((std::fprintf(stderr, "%s\n", compared.error().message.c_str()), 1));
    return std::move(*compared);
  }

  static constexpr std::uint64_t kRoom = std::uint64_t{8} << 30;

  api::Comparison first(const File& candidate, const Options& options) const {
    MeshCache cache(kRoom);
    return compare(cache, candidate, options);
  }
  api::Comparison second(MeshCache& warm, const File& candidate, const Options& options) const {
    return compare(warm, candidate, options);
  }
};

using Stages = std::array<double, 7>;
constexpr const char* kStages[] = {"read_a", "read_b", "build", "traverse", "reduce", "certify", "total"};

Stages stages_of(const api::Comparison& c) {
  const Timings& t = c.outcome.timings;
  return {c.times.read_a, c.times.read_b, t.build, t.traverse, t.reduce, t.certify, c.times.total};
}

// Keeps the run with the least total.
void keep_least(Stages& least, const Stages& stages, bool is_first) {
  if (is_first || stages.back() < least.back()) least = stages;
}

void print(const char* which, const Stages& stages) {
  std::printf("    %-7s", which);
  for (const double ms : stages) std::printf(" %9.2f", ms);
  std::printf("\n");
}

void run(const File& baseline, const std::vector<File>& candidates, int repetitions) {
  Options pass, fail;
  const Bench bench{baseline};
  MeshCache warm(Bench::kRoom);
  (void)bench.compare(warm, candidates.back(), Options{});
  for (const File& candidate : candidates) {
    const double upper = bench.compare(warm, candidate, Options{}).outcome.upper;
    pass.max_distance = 1.5 * upper + 1e-3;
    fail.max_distance = 0.5 * upper;
    Options one_sided;
    one_sided.direction = Direction::b_to_a;
    const Question questions[] = {{"symmetric, 1 %", {}},
                                  {"candidate to baseline, 1 %", one_sided},
                                  {"gate, passes", pass},
                                  {"gate, fails", fail}};
    for (const Question& question : questions) {
      Stages first{}, second{};
      for (int i = 0; i < repetitions; ++i) {
        keep_least(first, stages_of(bench.first(candidate, question.options)), i == 0);
        keep_least(second, stages_of(bench.second(warm, candidate, question.options)), i == 0);
      }
      std::printf("%s - %s, %s: %.1fx\n           ", baseline.name.c_str(), candidate.name.c_str(), question.name,
                  first.back() / second.back());
      for (const char* stage : kStages) std::printf(" %9s", stage);
      std::printf("\n");
      print("first", first);
      print("second", second);
    }
  }
  std::printf("held: %.1f MB\n", static_cast<double>(warm.counters().bytes) / 1e6);
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  if (argc > 3) {
    std::vector<File> candidates;
    for (int i = 3; i < argc; ++i) candidates.push_back(read_file(argv[i]));
    run(read_file(argv[2]), candidates, repetitions);
    return 0;
  }
  const Vec3 far(1000, -2000, 500);
  run({"500k.stl", to_stl(bumpy(354))},
      {{"5k.stl", to_stl(bumpy(35))},
       {"50k.stl", to_stl(bumpy(112))},
       {"500k_other.stl", to_stl(bumpy(350))},
       {"500k_dented.stl", to_stl(bumpy(354, 0.01))}},
      repetitions);
  run({"500k_far.stl", to_stl(bumpy(354, 0, far))}, {{"50k_far.stl", to_stl(bumpy(112, 0, far))}}, repetitions);
}
