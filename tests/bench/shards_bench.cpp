// What it costs to measure a large pair in parts (docs/sharding.md): shards_bench A B [--shards N] ...
//
// Each way runs in processes of its own, whose processor time is counted, reading included:
//   whole   one process, N threads
//   shared  one process that reads once and measures the parts in N threads: a worker that keeps its meshes
//   apart   N processes that each read both meshes and measure one part: workers on N machines
// Parts tell each other their lower bounds every --share-ms. `shards_bench --make PREFIX --rings R` writes pairs to
// try.
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/compare.h"
#include "engine/part.h"
#include "mesh_files.h"
#include "shapes.h"

namespace {

using namespace meshgauge;

struct Settings {
  std::string a, b, make;
  std::string direction = "symmetric";
  unsigned shards = 2;
  double diagonal = 1e-6;
  double relative = 0;
  unsigned share_ms = 500;
  std::uint32_t rings = 500;
  int repeat = 3;
  bool keep = false;
};

constexpr std::size_t kMost = 64;

// What the processes of one way know of each other: in memory that they share.
struct Board {
  std::atomic<double> lower[kMost];
  double part_lower[kMost];
  double part_upper[kMost];
  double read[kMost];    // seconds
  double build[kMost];   // ... of wall time
  double search[kMost];  // ... likewise
  double tests[kMost];   // point-triangle distances

  double best() const {
    double best = 0;
    for (const auto& known : lower) best = std::max(best, known.load());
    return best;
  }
};

Options options_of(const Settings& settings) {
  Options options;
  options.direction = settings.direction == "a_to_b" ? Direction::a_to_b : Direction::symmetric;
  options.tolerance = {std::nullopt, settings.diagonal, std::nullopt};
  if (settings.relative > 0) options.tolerance.relative = settings.relative;
  return options;
}

std::shared_ptr<const api::PreparedMesh> read(const std::string& path, const char* part, Prepared::Use use) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  Control control;
  const auto mesh =
      api::loading(&api::load, {part, std::as_bytes(std::span(bytes)), path, ""}, api::ReadLimits{}, use)(control);
  if (!mesh) throw std::runtime_error(mesh.error().message);
  return *mesh;
}

using Meshes = std::pair<std::shared_ptr<const api::PreparedMesh>, std::shared_ptr<const api::PreparedMesh>>;

Meshes read_both(const Settings& settings, Prepared::Use use, double& s) {
  const auto start = Control::Clock::now();
  Meshes pair{read(settings.a, "a", use), read(settings.b, "b", use)};
  s = std::chrono::duration<double>(Control::Clock::now() - start).count();
  return pair;
}

void measure_part(const api::PreparedMesh& a, const api::PreparedMesh& b, Options options, const Settings& settings,
                  Board& board) {
  Control control;
  const unsigned index = options.part.index;
  if (options.part.count > 1) {
    control.watch(
        [&](const Progress& progress) {
          board.lower[index] = progress.lower;
          control.know_lower(board.best());
        },
        std::chrono::milliseconds(settings.share_ms));
  }
  const Outcome outcome = measure(a.mesh, b.mesh, options, control);
  board.lower[index] = outcome.lower;
  board.part_lower[index] = outcome.lower;
  board.part_upper[index] = outcome.upper;
  for (const auto* directed : {&outcome.a_to_b, &outcome.b_to_a}) {
    if (*directed) board.tests[index] += static_cast<double>((*directed)->work.triangle_tests);
  }
  board.build[index] = outcome.timings.build / 1000;
  board.search[index] = (outcome.timings.traverse + outcome.timings.reduce + outcome.timings.certify) / 1000;
}

using Body = std::function<void(Board& board)>;

struct Cost {
  double wall = 0;
  double cpu = 0;
  double peak_mib = 0;
};

double seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

Cost run(const std::vector<Body>& bodies, Board& board) {
  new (&board) Board{};
  const auto start = Control::Clock::now();
  for (const Body& body : bodies) {
    if (fork() == 0) {
      body(board);
      _exit(0);
    }
  }
  Cost cost;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    rusage used{};
    int status = 0;
    if (wait4(-1, &status, 0, &used) < 0 || status != 0) throw std::runtime_error("a process failed");
    cost.cpu += seconds(used.ru_utime) + seconds(used.ru_stime);
    cost.peak_mib += static_cast<double>(used.ru_maxrss) / 1024;
  }
  cost.wall = std::chrono::duration<double>(Control::Clock::now() - start).count();
  return cost;
}

void whole(const Settings& settings, Board& board) {
  const auto [a, b] = read_both(settings, Prepared::Use::once, board.read[0]);
  Options options = options_of(settings);
  options.threads = settings.shards;
  measure_part(*a, *b, options, settings, board);
}

void shared(const Settings& settings, Board& board) {
  const auto pair = read_both(settings, settings.keep ? Prepared::Use::often : Prepared::Use::once, board.read[0]);
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < settings.shards; ++i) {
    Options options = options_of(settings);
    options.part = {i, settings.shards};
    threads.emplace_back([&, options] { measure_part(*pair.first, *pair.second, options, settings, board); });
  }
  for (std::thread& thread : threads) thread.join();
}

void apart(const Settings& settings, unsigned index, Board& board) {
  const auto [a, b] = read_both(settings, Prepared::Use::once, board.read[index]);
  Options options = options_of(settings);
  options.part = {index, settings.shards};
  measure_part(*a, *b, options, settings, board);
}

void show(const char* way, const Cost& cost, const Board& board, double reference) {
  double lower = 0, upper = 0, read = 0, build = 0, search = 0, tests = 0;
  for (std::size_t i = 0; i < kMost; ++i) {
    lower = std::max(lower, board.part_lower[i]);
    upper = std::max(upper, board.part_upper[i]);
    read += board.read[i], build += board.build[i], search += board.search[i], tests += board.tests[i];
  }
  std::printf(
      "%-7s wall %7.3f s  cpu %7.3f s  %+6.1f %%  peak %5.0f MiB  [%.17g, %.17g]  read %.2f build %.2f search %.2f s  "
      "%.1f M tests\n",
      way, cost.wall, cost.cpu, 100 * (cost.cpu / reference - 1), cost.peak_mib, lower, upper, read, build, search,
      1e-6 * tests);
  std::fflush(stdout);
}

void measure_ways(const Settings& settings) {
  void* const memory = mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no memory");
  Board& board = *new (memory) Board;
  for (int i = 0; i < settings.repeat; ++i) {
    const Cost at_once = run({[&](Board& b) { whole(settings, b); }}, board);
    show("whole", at_once, board, at_once.cpu);
    show("shared", run({[&](Board& b) { shared(settings, b); }}, board), board, at_once.cpu);
    std::vector<Body> each;
    for (unsigned p = 0; p < settings.shards; ++p) each.push_back([&, p](Board& b) { apart(settings, p, b); });
    show("apart", run(each, board), board, at_once.cpu);
  }
}

// Of 4 R^2 triangles. near: the same bumps, a little turned. shell: one percent larger. noisy: every vertex moved by up
// to a thousandth. far: two that do not touch.
void make(const Settings& settings) {
  const auto bumpy = [&](double phase) {
    Mesh mesh = shapes::sphere(settings.rings);
    for (Vec3& p : mesh.positions) {
      p *= 1 + 0.05 * std::sin(7 * p.x() + phase) * std::cos(5 * p.y()) * std::sin(6 * p.z() + phase);
    }
    return mesh;
  };
  const Mesh plain = bumpy(0);
  bench::write_binary_ply(plain, settings.make + "plain.ply");
  bench::write_binary_ply(bumpy(0.02), settings.make + "near.ply");
  bench::write_binary_ply(shapes::scaled(bumpy(0), 1.01), settings.make + "shell.ply");
  bench::write_binary_ply(shapes::moved(bumpy(0.5), Vec3(3, 0.5, 0.2)), settings.make + "far.ply");
  Mesh noisy = plain;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> noise(-1e-3, 1e-3);
  for (Vec3& p : noisy.positions) p += Vec3(noise(random), noise(random), noise(random));
  bench::write_binary_ply(noisy, settings.make + "noisy.ply");
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Processor time of a comparison at once and in parts");
  app.add_option("A", settings.a, "a mesh file");
  app.add_option("B", settings.b, "another");
  app.add_option("--shards", settings.shards)->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--direction", settings.direction, "symmetric or a_to_b")->capture_default_str();
  app.add_option("--diagonal", settings.diagonal, "the tolerance")->capture_default_str();
  app.add_option("--relative", settings.relative, "the same, of the distance; 0: none")->capture_default_str();
  app.add_option("--share-ms", settings.share_ms)->capture_default_str();
  app.add_flag("--keep", settings.keep, "the meshes of `shared` are kept for other comparisons");
  app.add_option("--repeat", settings.repeat)->capture_default_str();
  app.add_option("--make", settings.make, "write meshes of this prefix");
  app.add_option("--rings", settings.rings, "of those: 4 R^2 triangles")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    if (!settings.make.empty()) return make(settings), 0;
    return measure_ways(settings), 0;
  } catch (const std::exception& e) {
    return std::fprintf(stderr, "shards_bench: %s\n", e.what()), 1;
  }
}
