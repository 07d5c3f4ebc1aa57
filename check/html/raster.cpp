#include "check/html/raster.h"

#include <algorithm>
#include <cmath>

namespace meshgauge::check {
namespace {

constexpr std::int64_t kSteps = 64;  // per pixel

// A corner on the grid of 64ths: edges are tested in integers, without error. A camera magnifies at most about a
// hundredfold, so that products stay far below 2^63.
struct Corner {
  std::int64_t x = 0;
  std::int64_t y = 0;
  double depth = 0;
};

Corner corner(const Seen& seen) {
  return {std::llround(seen.x * static_cast<double>(kSteps)), std::llround(seen.y * static_cast<double>(kSteps)),
          seen.depth};
}

// Twice the area of (a, b, p), positive on one side of the edge: at p, and its change for one pixel right and down.
struct Edge {
  std::int64_t value;
  std::int64_t right;
  std::int64_t down;
};

Edge edge(const Corner& a, const Corner& b, std::int64_t x, std::int64_t y) {
  return {(b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x), -(b.y - a.y) * kSteps, (b.x - a.x) * kSteps};
}

// Pixels of `count` whose centres lie within [low, high].
struct Range {
  int first;
  int last;
};
Range middles(std::int64_t low, std::int64_t high, int count) {
  const auto middle_after = [](std::int64_t x) { return (x + kSteps / 2 - 1) >> 6; };  // (x - 32) / 64, rounded up
  const auto middle_before = [](std::int64_t x) { return (x - kSteps / 2) >> 6; };
  return {static_cast<int>(std::clamp<std::int64_t>(middle_after(low), 0, count)),
          static_cast<int>(std::clamp<std::int64_t>(middle_before(high), -1, count - 1))};
}

class Raster {
 public:
  Raster(Samples& samples, double cut) : samples_(samples), cut_(cut) {}

  void draw(const Corner& a, Corner b, Corner c, std::uint32_t triangle) {
    std::int64_t area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    if (area < 0) std::swap(b, c), area = -area;
    const auto [left, right] = std::minmax({a.x, b.x, c.x});
    const auto [above, below] = std::minmax({a.y, b.y, c.y});
    const Range columns = middles(left, right, samples_.width), rows = middles(above, below, samples_.height);
    if (columns.first > columns.last || rows.first > rows.last) return;

    const std::int64_t x = columns.first * kSteps + kSteps / 2, y = rows.first * kSteps + kSteps / 2;
    Edge edges[3] = {edge(b, c, x, y), edge(c, a, x, y), edge(a, b, x, y)};
    const double depths[3] = {a.depth, b.depth, c.depth};
    for (int row = rows.first; row <= rows.last; ++row) {
      draw_row(edges, depths, static_cast<double>(area), row, columns, triangle);
      for (Edge& each : edges) each.value += each.down;
    }
  }

  // The square around a point, which is turned to the viewer.
  void draw_point(const Seen& at, std::uint32_t triangle) {
    constexpr int kAround = kPointSize / 2;
    if (!(std::abs(at.x) < 1e6 && std::abs(at.y) < 1e6)) return;
    const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
    for (int row = std::max(y - kAround, 0); row <= std::min(y + kAround, samples_.height - 1); ++row) {
      for (int column = std::max(x - kAround, 0); column <= std::min(x + kAround, samples_.width - 1); ++column)
        show(samples_.at(column, row), at.depth, triangle);
    }
  }

 private:
  void draw_row(const Edge (&edges)[3], const double (&depths)[3], double area, int row, const Range& columns,
                std::uint32_t triangle) {
    std::int64_t a = edges[0].value, b = edges[1].value, c = edges[2].value;
    bool entered = false;
    for (int column = columns.first; column <= columns.last; ++column) {
      if ((a | b | c) >= 0) {
        entered = true;
        const double depth = (static_cast<double>(a) * depths[0] + static_cast<double>(b) * depths[1] +
                              static_cast<double>(c) * depths[2]) /
                             area;
        show(samples_.at(column, row), depth, triangle);
      } else if (entered) {
        return;  // no more in this row: a triangle is convex
      }
      a += edges[0].right, b += edges[1].right, c += edges[2].right;
    }
  }

  void show(std::size_t at, double depth, std::uint32_t triangle) {
    if (depth > cut_ || !(static_cast<float>(depth) > samples_.depth[at])) return;
    samples_.depth[at] = static_cast<float>(depth);
    samples_.triangle[at] = triangle;
  }

  Samples& samples_;
  const double cut_;
};

}  // namespace

Samples rasterise(MeshView mesh, const Camera& camera, double cut) {
  Samples samples;
  samples.width = camera.width;
  samples.height = camera.height;
  const std::size_t count = samples.at(0, camera.height);
  samples.triangle.assign(count, Samples::kNone);
  samples.depth.assign(count, -std::numeric_limits<float>::infinity());
  Raster raster(samples, cut);
  const bool points = is_cloud(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (points) {
      raster.draw_point(camera.see(mesh.corner(t, 0)), static_cast<std::uint32_t>(t));
      continue;
    }
    raster.draw(corner(camera.see(mesh.corner(t, 0))), corner(camera.see(mesh.corner(t, 1))),
                corner(camera.see(mesh.corner(t, 2))), static_cast<std::uint32_t>(t));
  }
  return samples;
}

}  // namespace meshgauge::check
