// Prints the tightness of the strategies' bounds and their time: tests/engine/bounds/tightness.h, the paper's Figure 2.
//
//   bench_tightness MESH_A MESH_B [--sample N] [--pair NAME]
//
// Takes N triangles of A (1000 by default, or all if there are fewer), evenly spread over the file's order, and bounds
// the distance of each from B. Triangles nearer to B than 1e-6 of the unit frame are left out: there
// the error of h is more than 0.1 % of it. Prints CSV: a line of names, then one line for each stencil of n_point and
// one for triangle_set.
//
//   pair              NAME; by default the files' names without extensions, "bunny-bunny_half"
//   strategy          n_point (with 4 points it is four_point) or triangle_set
//   points            samples of n_point: 4, 10, 31, 109, 409 or 1585; empty for triangle_set
//   triangles         triangles of A that count
//   mean_tightness    tau = (upper - h) / h over those triangles, the paper's eq. 13; 0 is the optimum
//   median_tightness
//   most_tightness
//   seconds_per_bound of PieceBound::upper(), on one thread: the median of five passes over the triangles, divided by
//                     their number (fewer passes if they take ten seconds). The nearest points of A's vertices are
//                     computed before, as in a measurement, where neighbours share them.
//
// All numbers except the last are the same in every run. Exits with 1 and a message on stderr if a mesh cannot be read.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/mesh/frame.h"
#include "engine/paper/n_point.h"
#include "engine/paper/triangle_set.h"
#include "engine/tree/ordered_mesh.h"
#include "tests/bench/read.h"
#include "tests/engine/bounds/tightness.h"

namespace {

using namespace meshgauge;
using bench::read;
using Seconds = std::chrono::duration<double>;
constexpr double kNear = 1e-6;

void move_to_unit_frame(Mesh& a, Mesh& b) {
  Box box = bounding_box(a);
  box.extend(bounding_box(b));
  const Frame frame(box);
  for (Mesh* mesh : {&a, &b}) {
    for (Vec3& p : mesh->positions) p = frame.to_frame(p);
  }
}

class Patient final : public Monitor {
  std::optional<Stop> pulse(const Search&) override { return std::nullopt; }
  bool interrupted() override { return false; }
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

struct Bounded {
  std::vector<double> uppers;
  double seconds_each = 0;
};

class Bench {
 public:
  Bench(const Mesh& a, const Mesh& b, std::size_t sample)
      : ordered_(b, {}, bounding_box(b), Frame{}, control_, pool_),
        to_(ordered_.view(), *find_kernels("auto"), control_, pool_),
        search_(a, bounding_box(a), to_, Goal{}, 0, monitor_, pool_) {
    const std::size_t n = std::min(sample, a.triangles.size());
    for (std::size_t i = 0; i < n; ++i) {
      const auto triangle = static_cast<std::uint32_t>(i * a.triangles.size() / n);
      const double h = distance_by_subdivision(a, triangle, b);
      if (h < kNear) continue;
      distances_.push_back(h);
      Piece& piece = pieces_.emplace_back();
      piece.triangle = triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        piece.corners[k] = nearest_corner(to_, a.positions[a.triangles[triangle][k]], search_.work());
      }
    }
    if (pieces_.empty()) throw std::runtime_error("no triangle is far enough from B");
  }

  void print_all(const std::string& pair) {
    std::puts("pair,strategy,points,triangles,mean_tightness,median_tightness,most_tightness,seconds_per_bound");
    for (const int points : {4, 10, 31, 109, 409, 1585}) {
      NPoint bound(to_, stencil_level(points).value(), search_.work());
      print(pair + ",n_point," + std::to_string(points), timed(bound));
    }
    TriangleSet bound(search_);
    print(pair + ",triangle_set,", timed(bound));
  }

 private:
  // Few passes: with hundreds, branch prediction would adapt to the short ones.
  Bounded timed(PieceBound& bound) const {
    Bounded result;
    std::vector<double> passes;
    double total = 0;
    while (passes.size() < 5 && total < 10) {
      result.uppers.clear();
      const auto start = std::chrono::steady_clock::now();
      for (const Piece& piece : pieces_) result.uppers.push_back(bound.upper(piece));
      passes.push_back(Seconds(std::chrono::steady_clock::now() - start).count());
      total += passes.back();
    }
    result.seconds_each = median(passes) / static_cast<double>(pieces_.size());
    return result;
  }

  void print(const std::string& what, const Bounded& bounded) const {
    std::vector<double> taus;
    double sum = 0;
    for (std::size_t i = 0; i < distances_.size(); ++i) {
      taus.push_back(tightness(bounded.uppers[i], distances_[i]));
      sum += taus.back();
    }
    std::printf("%s,%zu,%.6g,%.6g,%.6g,%.4e\n", what.c_str(), taus.size(), sum / static_cast<double>(taus.size()),
                median(taus), *std::max_element(taus.begin(), taus.end()), bounded.seconds_each);
    std::fflush(stdout);
  }

  Control control_;
  ThreadPool pool_{1};
  OrderedMesh ordered_;
  Bvh to_;
  Patient monitor_;
  Search search_;
  std::vector<Piece> pieces_;
  std::vector<double> distances_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Tightness of the strategies' bounds against the time they take, as CSV.");
  std::string path_a, path_b, pair;
  std::size_t sample = 1000;
  app.add_option("mesh_a", path_a, "the mesh measured from")->required();
  app.add_option("mesh_b", path_b, "the mesh measured to")->required();
  app.add_option("--sample", sample, "triangles of A")->check(CLI::PositiveNumber);
  app.add_option("--pair", pair, "name of the pair in the output");
  CLI11_PARSE(app, argc, argv);
  const auto stem = [](const std::string& path) {
    const std::string name = std::filesystem::path(path).filename().string();
    return name.substr(0, name.find('.', 1));
  };
  if (pair.empty()) pair = stem(path_a) + "-" + stem(path_b);
  try {
    Mesh a = read(path_a);
    Mesh b = read(path_b);
    move_to_unit_frame(a, b);
    Bench(a, b, sample).print_all(pair);
  } catch (const std::exception& e) {
    std::cerr << "bench_tightness: " << e.what() << '\n';
    return 1;
  }
}
