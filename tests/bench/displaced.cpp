// Counts how often alignment (engine/extras/align/align.h) finds the pose of displaced copies.
//
//   bench_align MESH... [--copies N] [--seed S] [--threads N] [--axes]
//
// Copy i is of mesh i modulo the number of meshes, turned about a random axis by up to 30 degrees and shifted by up to
// 10 % of the diagonal. By turns it is exact; with noise of 0.2 % of the diagonal at each vertex; a part, four fifths
// of the triangles on one side of a random plane; a part with noise. The best known residual is the smaller of what
// alignment finds from the given pose and from the true inverse pose. Prints one line of CSV a copy and, last, how many
// ended within 1 % of the best known residual (or below 1e-9 of the diagonal). Exits with 1 where one did not.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "engine/extras/align/align.h"
#include "tests/bench/read.h"

namespace {

using namespace meshgauge;

struct Dice {
  std::mt19937_64 bits;

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(bits); }
  double normal() { return std::normal_distribution<double>()(bits); }
  Vec3 direction() { return Vec3(normal(), normal(), normal()).normalized(); }
};

RigidMotion displaced(const Mesh& mesh, Dice& dice) {
  const Box box = bounding_box(mesh);
  const Vec3 centre = (box.low + box.high) / 2;
  const double angle = dice.uniform(0, 30) * 3.14159265358979 / 180;
  const RigidMotion::Matrix turn = Eigen::AngleAxisd(angle, dice.direction()).toRotationMatrix();
  return {turn, centre - turn * centre + dice.uniform(0, 0.1) * diagonal(box) * dice.direction()};
}

void add_noise(Mesh& mesh, Dice& dice) {
  const double sigma = 0.002 * diagonal(mesh);
  for (Vec3& p : mesh.positions) p += sigma * Vec3(dice.normal(), dice.normal(), dice.normal());
}

void leave_part(Mesh& mesh, Dice& dice) {
  const Vec3 normal = dice.direction();
  const auto height = [&](const Triangle& t) { return normal.dot(mesh.positions[t[0]]); };
  std::ranges::sort(mesh.triangles, {}, height);
  mesh.triangles.resize(mesh.triangles.size() * 4 / 5 + 1);
}

constexpr const char* kKinds[] = {"exact", "noise", "part", "part with noise"};

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> files;
  std::size_t copies = 300;
  std::uint64_t seed = 1;
  unsigned threads = 1;
  AlignOptions options;
  CLI::App app("Counts how often alignment finds the pose of displaced copies");
  app.add_option("meshes", files)->required();
  app.add_option("--copies", copies);
  app.add_option("--seed", seed);
  app.add_option("--threads", threads);
  app.add_flag("--axes", options.principal_axes);
  CLI11_PARSE(app, argc, argv);
  try {
    Dice dice{std::mt19937_64(seed)};
    std::size_t good = 0;
    std::puts("mesh,kind,degrees,before,residual,best,steps,converged,seconds");
    for (std::size_t i = 0; i < copies; ++i) {
      const std::string& file = files[i % files.size()];
      const Mesh fixed = bench::read(file);
      const std::size_t kind = i / files.size() % std::size(kKinds);
      const RigidMotion away = displaced(fixed, dice);
      Mesh copy = fixed;
      if (kind % 2 == 1) add_noise(copy, dice);
      if (kind >= 2) leave_part(copy, dice);
      for (Vec3& p : copy.positions) p = away(p);
      Control control;
      const Prepared a(copy), b(fixed);
      const auto begun = Control::Clock::now();
      const Alignment found = *align(a, b, options, threads, "auto", control);
      const double seconds = ms_since(begun) / 1000;
      const Alignment known = *align(a, b, {away.inverse()}, threads, "auto", control);
      const double size = diagonal(fixed), best = std::min(found.residual, known.residual);
      const bool is_good = found.residual <= 1.01 * best || found.residual <= 1e-9 * size;
      good += is_good ? 1 : 0;
      std::printf("%s,%s,%.1f,%.3g,%.6g,%.6g,%d,%d,%.3f%s\n", file.substr(file.rfind('/') + 1).c_str(), kKinds[kind],
                  displacement(fixed, bounding_box(fixed), away)->angle, found.before / size, found.residual / size,
                  best / size, found.steps, found.converged, seconds, is_good ? "" : ",MISSED");
      std::fflush(stdout);
    }
    std::printf("%zu of %zu\n", good, copies);
    return good == copies ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_align: %s\n", error.what());
    return 1;
  }
}
