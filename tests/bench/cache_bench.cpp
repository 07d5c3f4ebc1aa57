// Measures what a cached baseline saves. Compares a baseline with candidates: first with no mesh cached, then with the
// baseline cached by another comparison, then with both cached. Prints milliseconds for each stage.
//
//   cache_bench [REPETITIONS [BASELINE CANDIDATE...]]
//
// Without files: a bumpy sphere of half a million triangles against coarser ones, one of other vertices, a copy with a
// dent, and a copy far from the origin. One thread. Shows the repetition with the smallest processor time (`cpu`) and
// the factor of that time, which other load on the machine changes little.
#include <time.h>

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

#include "api/base/digest.h"
#include "api/compare/compare.h"
#include "server/measure/mesh_cache.h"
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

// The radius of the bumpy sphere near p; it does not depend on the tessellation.
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

constexpr std::uint64_t kRoom = std::uint64_t{8} << 30;

using Get = MeshCache::Load;

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

api::Comparison compare(const Get& a, const Get& b, const Options& options) {
  Control control;
  api::StageTimes times;
  const auto start = std::chrono::steady_clock::now();
  const auto mesh_a = a(control).value();
  times.read_a = ms_since(start);
  const auto mesh_b = b(control).value();
  times.read_b = ms_since(start) - times.read_a;
  auto compared = api::compare(mesh_a, mesh_b, options, control, times);
  if (!compared) std::exit((std::fprintf(stderr, "%s\n", compared.error().message.c_str()), 1));
  return std::move(*compared);
}

// A file that is loaded each time, or kept in a cache.
struct Source {
  const File& file;
  const std::string id = api::sha256_hex(std::as_bytes(std::span(file.bytes)));
  const api::MeshInput input = {"", std::as_bytes(std::span(file.bytes)), file.name, ""};

  Result<api::SharedMesh> load(Prepared::Use use, Control& control) const {
    return api::prepare(api::load(input, {}), input, use, control);
  }
  Get anew() const {
    return [this](Control& control) { return load(Prepared::Use::once, control); };
  }
  Get from(MeshCache& cache) const {
    return [this, &cache](Control& control) {
      const Get loading = [this](Control& job) { return load(Prepared::Use::often, job); };
      return cache.get(MeshCache::key("", id, file.name, ""), loading, control);
    };
  }
};

using Stages = std::array<double, 8>;
constexpr const char* kStages[] = {"read_a", "read_b", "build", "traverse", "reduce", "certify", "total", "cpu"};

double cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

// Times one comparison; `least` keeps the best.
void keep_least(Stages& least, bool is_first, const Get& a, const Get& b, const Options& options) {
  const double before = cpu_ms();
  const api::Comparison c = compare(a, b, options);
  const double cpu = cpu_ms() - before;
  const Timings& t = c.outcome.timings;
  if (!is_first && cpu >= least.back()) return;
  least = {c.times.read_a, c.times.read_b, t.build, t.traverse, t.reduce, t.certify, c.times.total, cpu};
}

void print(const char* which, const Stages& stages) {
  std::printf("    %-7s", which);
  for (const double ms : stages) std::printf(" %9.2f", ms);
  std::printf("\n");
}

// Returns the options to compare with. `upper`: upper bound of the distance of the candidate.
std::vector<Question> questions(double upper) {
  Options one_sided, coarse, pass, fail;
  one_sided.direction = Direction::b_to_a;
  coarse.tolerance = {std::nullopt, 0.01, std::nullopt};
  pass.max_distance = 4 * upper + 1e-3;
  fail.max_distance = 0.5 * upper;
  return {{"within 1 % of the distance", {}},
          {"the same, candidate to baseline", one_sided},
          {"within 1 % of the diagonal", coarse},
          {"gate at 4 times the distance", pass},
          {"gate at half of it", fail}};
}

void run(const File& baseline, const std::vector<File>& candidates, int repetitions) {
  const Source a{baseline};
  MeshCache warm(kRoom);
  (void)compare(a.from(warm), Source{candidates.back()}.anew(), Options{});
  for (const File& candidate : candidates) {
    const Source b{candidate};
    MeshCache both(kRoom);
    const double upper = compare(a.from(both), b.from(both), Options{}).outcome.upper;
    for (const Question& question : questions(upper)) {
      Stages first{}, second{}, again{};
      for (int i = 0; i < repetitions; ++i) {
        MeshCache cold(kRoom);  // destroyed after the clock has stopped
        keep_least(first, i == 0, a.from(cold), b.anew(), question.options);
        keep_least(second, i == 0, a.from(warm), b.anew(), question.options);
        keep_least(again, i == 0, a.from(both), b.from(both), question.options);
      }
      std::printf("%s - %s, %s: %.1fx, both cached %.1fx\n           ", baseline.name.c_str(), candidate.name.c_str(),
                  question.name, first.back() / second.back(), first.back() / again.back());
      for (const char* stage : kStages) std::printf(" %9s", stage);
      std::printf("\n");
      print("first", first);
      print("second", second);
      print("both", again);
    }
  }
  std::printf("held of the baseline: %.1f MB\n", static_cast<double>(warm.counters().bytes) / 1e6);
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
