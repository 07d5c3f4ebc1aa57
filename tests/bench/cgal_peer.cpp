// The peer of ./dev bench: CGAL's bounded_error_Hausdorff_distance on two mesh files, one thread.
//
//   bench_cgal A B TOLERANCE LIMIT_SECONDS
//
// The error bound is TOLERANCE * diagonal of A, as in `meshgauge compare --direction a_to_b --diagonal TOLERANCE`.
// The project's own readers read the files, so both measure the same triangles. CGAL's mesh is made of them first,
// timed as `prepare_seconds`; `seconds` is the one call, which builds CGAL's trees. Prints one line of JSON.
//
// CGAL's Polygon Mesh Processing is under the GPL: it is linked into this program alone, never into the product.
#include <CGAL/Kernel/global_functions.h>  // distance.h needs it and does not include it
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <vector>

#include "api/formats/format.h"

namespace {

using meshgauge::Mesh;
using Clock = std::chrono::steady_clock;
// The faster kernel for CGAL: with Exact_predicates_inexact_constructions_kernel the same pairs take longer
// (docs/benchmarks.md).
using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

[[noreturn]] void fail(const char* status) {
  std::printf("{\"status\": \"%s\"}\n", status);
  std::fflush(stdout);
  std::_Exit(0);
}

Mesh read(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  auto read = meshgauge::api::read_mesh(std::as_bytes(std::span(bytes)), {"mesh", path, ""}, {});
  if (!read) {
    std::fprintf(stderr, "bench_cgal: %s: %s\n", path, read.error().message.c_str());
    fail("unread");
  }
  return std::move(read->mesh);
}

// Returns the same set of points as a mesh for CGAL: CGAL rejects faces with a repeated corner and meshes that are not
// manifold, so points at one place are merged, such faces and duplicates dropped, and vertices doubled where the
// surface is not manifold.
Surface to_surface(const Mesh& mesh) {
  std::vector<Kernel::Point_3> points;
  points.reserve(mesh.positions.size());
  for (const auto& p : mesh.positions) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::vector<std::size_t>> faces;
  faces.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) faces.push_back({t[0], t[1], t[2]});
  pmp::repair_polygon_soup(points, faces);
  pmp::orient_polygon_soup(points, faces);
  Surface surface;
  pmp::polygon_soup_to_polygon_mesh(points, faces, surface);
  return surface;
}

void limit(double seconds) {
  signal(SIGALRM, [](int) {
    static constexpr char kLine[] = "{\"status\": \"timeout\"}\n";
    _exit(write(STDOUT_FILENO, kLine, sizeof kLine - 1) < 0);
  });
  alarm(static_cast<unsigned>(seconds));
}

int run(const char* path_a, const char* path_b, double tolerance, double limit_seconds) {
  const Mesh mesh_a = read(path_a), mesh_b = read(path_b);
  const double diagonal = meshgauge::diagonal(mesh_a);
  auto start = Clock::now();
  const Surface a = to_surface(mesh_a), b = to_surface(mesh_b);
  const double prepare_seconds = seconds_since(start);
  limit(limit_seconds);
  start = Clock::now();
  const double distance = pmp::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(a, b, tolerance * diagonal);
  const double seconds = seconds_since(start);
  alarm(0);
  std::printf(
      "{\"status\": \"converged\", \"distance\": %.17g, \"diagonal\": %.17g, \"seconds\": %.9g, "
      "\"prepare_seconds\": %.9g, \"faces_a\": %u, \"faces_b\": %u}\n",
      distance, diagonal, seconds, prepare_seconds, static_cast<unsigned>(faces(a).size()),
      static_cast<unsigned>(faces(b).size()));
  return 0;
}

double number(const char* text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text, text + std::char_traits<char>::length(text), value);
  if (error != std::errc{} || *end != '\0') {
    std::fprintf(stderr, "bench_cgal: not a number: %s\n", text);
    std::exit(2);
  }
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return std::fprintf(stderr, "usage: bench_cgal A B TOLERANCE LIMIT_SECONDS\n"), 2;
  try {
    return run(argv[1], argv[2], number(argv[3]), number(argv[4]));
  } catch (const std::bad_alloc&) {
    fail("memory");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_cgal: %s\n", error.what());
    fail("error");
  }
}
