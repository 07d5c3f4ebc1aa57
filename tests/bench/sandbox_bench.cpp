// The cost of reading uploads in separate processes: times sandbox::Pool::load() and api::load(), which does the same
// work in this process, on a mesh of two triangles and on a binary STL and an OBJ of about 100 MB (2 million
// triangles), each uploaded again for every reading. Then measures how long a reading goes on after its deadline.
//
//   sandbox_bench [repetitions]     with `taskset -c 0`: the figures without a second processor
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/digest.h"
#include "api/compare/load.h"
#include "api/formats/read_part.h"
#include "server/http/upload.h"
#include "server/sandbox/become_reader.h"
#include "server/sandbox/pool.h"
#include "server/sandbox/reader/image.h"
#include "server/sandbox/spawner.h"

namespace {

using namespace meshgauge;
using Clock = std::chrono::steady_clock;

constexpr int kSide = 1000;  // of a height field of kSide x kSide squares, two triangles each
constexpr int kSmallRepetitions = 200;

// Coordinates of 16 digits, as double precision exporters write them.
Vec3 grid_point(int i, int j) {
  const double x = 0.1234567891 * i + 1.0 / 3;
  const double y = 0.1234567891 * j + 1.0 / 7;
  return {x, y, std::sin(x) * std::cos(y)};
}

void append(std::string& text, const char* before, auto number) {
  char digits[32];
  text += before;
  text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

std::string grid_obj() {
  std::string text;
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      const Vec3 p = grid_point(i, j);
      for (int k = 0; k < 3; ++k) append(text, k == 0 ? "v " : " ", p[k]);
      text += '\n';
    }
  }
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const int corner = i * (kSide + 1) + j + 1;
      const int others[] = {corner + kSide + 1, corner + kSide + 2, corner + kSide + 2, corner + 1};
      for (int half = 0; half < 2; ++half) {
        append(text, "f ", corner);
        append(text, " ", others[2 * half]);
        append(text, " ", others[2 * half + 1]);
        text += '\n';
      }
    }
  }
  return text;
}

std::string grid_stl() {
  constexpr std::uint32_t kTriangles = 2 * kSide * kSide;
  std::string bytes(84 + std::size_t{50} * kTriangles, '\0');
  std::memcpy(bytes.data() + 80, &kTriangles, sizeof kTriangles);
  char* facet = bytes.data() + 84;
  for (int square = 0; square < kSide * kSide; ++square) {
    const int i = square / kSide;
    const int j = square % kSide;
    const Vec3 corners[] = {grid_point(i, j), grid_point(i + 1, j), grid_point(i + 1, j + 1), grid_point(i, j + 1)};
    for (const auto& triangle : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3f p = corners[triangle[k]].cast<float>();
        std::memcpy(facet + 12 * (k + 1), p.data(), 12);
      }
      facet += 50;
    }
  }
  return bytes;
}

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double least(std::vector<double> times) { return *std::ranges::min_element(times); }

double median(std::vector<double> times) {
  std::ranges::sort(times);
  return times[times.size() / 2];
}

using Load = std::function<Result<api::LoadedMesh>(const api::MeshInput&, const api::ReadLimits&, Control&)>;

Result<api::LoadedMesh> load_here(const api::MeshInput& input, const api::ReadLimits& limits, Control&) {
  return api::load(input, limits);
}

// The time that `load` takes for one upload of these bytes.
double ms_of(std::string_view bytes, const Load& load) {
  server::ByteBudget budget(std::uint64_t{1} << 40);
  server::Upload upload(budget, "/tmp");
  Control control;
  if (upload.append(bytes) || upload.finish()) std::exit(1);
  const auto start = Clock::now();
  const auto loaded = load({"a", upload.bytes(), "", "", upload.file()}, {}, control);
  const double ms = ms_since(start);
  if (!loaded) {
    std::fprintf(stderr, "%s\n", loaded.error().message.c_str());
    std::exit(1);
  }
  return ms;
}

void compare(const char* name, std::string_view bytes, const Load& apart, int repetitions) {
  std::vector<double> here;
  std::vector<double> there;
  for (int i = 0; i <= repetitions; ++i) {
    const double ms_here = ms_of(bytes, load_here);
    const double ms_there = ms_of(bytes, apart);
    if (i == 0) continue;  // warms up
    here.push_back(ms_here);
    there.push_back(ms_there);
  }
  std::printf("%s, %.1f MB, of %d\n", name, static_cast<double>(bytes.size()) / 1e6, repetitions);
  for (const auto& [what, of] : {std::pair{"least", &least}, std::pair{"median", &median}}) {
    std::printf("  %-6s  %.3f ms in this process, %.3f ms in another: %+.3f ms, %+.1f %%\n", what, of(here), of(there),
                of(there) - of(here), 100 * (of(there) / of(here) - 1));
  }
}

// The time without the digest, which the server computes while the worker reads.
void time_parts(const char* name, std::string_view bytes) {
  const auto span = std::as_bytes(std::span(bytes));
  auto start = Clock::now();
  const auto read = api::read_part(span, {"a", "", ""}, {});
  const double reading = ms_since(start);
  start = Clock::now();
  const std::string digest = api::sha256_hex(span);
  std::printf("%s in this process: reading and welding %.1f ms, its digest %.1f ms\n", name, reading, ms_since(start));
  if (!read || digest.empty()) std::exit(1);
}

void time_deadline(std::string_view bytes, server::sandbox::Pool& pool, int repetitions) {
  server::ByteBudget budget(std::uint64_t{1} << 40);
  server::Upload upload(budget, "/tmp");
  if (upload.append(bytes) || upload.finish()) std::exit(1);
  double worst = 0;
  for (int i = 0; i < repetitions; ++i) {
    const auto deadline = Clock::now() + std::chrono::milliseconds(20 + 5 * i);
    Control control(deadline);
    const auto loaded = pool.load({"a", upload.bytes(), "", "", upload.file()}, {}, control);
    if (loaded) continue;  // it ended before the deadline
    worst = std::max(worst, ms_since(deadline));
  }
  std::printf("after its deadline a reading goes on for at most %.1f ms (of %d)\n", worst, repetitions);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "sandbox") {
    return server::sandbox::run_spawner(api::read_part,
                                        server::sandbox::become_reader(server::sandbox::reader_image(), argv));
  }
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 15;
  constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
  server::sandbox::Pool pool({{"/proc/self/exe", "sandbox"}, 2, {6 * kGiB, kGiB, 200, true}},
                             [](const std::string&) {});
  const auto lacks = pool.start();
  if (!lacks) {
    std::fprintf(stderr, "%s\n", lacks.error().message.c_str());
    return 1;
  }
  for (const std::string& lack : *lacks) std::printf("%s\n", lack.c_str());
  const Load apart = [&pool](const api::MeshInput& input, const api::ReadLimits& limits, Control& control) {
    return pool.load(input, limits, control);
  };
  const std::string stl = grid_stl();
  const std::string obj = grid_obj();
  compare("two triangles", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", apart, kSmallRepetitions);
  compare("binary STL", stl, apart, repetitions);
  compare("OBJ", obj, apart, repetitions);
  time_parts("binary STL", stl);
  time_parts("OBJ", obj);
  time_deadline(stl, pool, repetitions);
}
