#include "check/html/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "check/html/raster.h"

namespace meshgauge::check {
namespace {

constexpr int kFiner = 2;  // samples per pixel along each axis
constexpr int kRowsATask = 16;
constexpr double kAmbient = 0.58;
// Shares of white that keep the shape visible in the darkest colours, most where the light is perpendicular.
constexpr double kGlow = 0.06, kSheen = 0.2;
constexpr double kInside = 0.42;                         // share of the light on the inner side
const Vec3 kLight = Vec3(-0.35, 0.5, 0.8).normalized();  // right, up, toward
constexpr double kOutline = 0.45;                        // share of the light at a step in depth
constexpr float kStep = 7;                               // size of a step in depth, in samples
constexpr int kHatchPeriod = 14, kHatchWidth = 4;        // in samples
constexpr std::array<double, 3> kHatch{255, 196, 178};
constexpr std::array<double, 3> kGrey{190, 197, 205};  // without a distance

Camera finer(Camera camera) {
  camera.width *= kFiner;
  camera.height *= kFiner;
  camera.pixels_per_unit *= kFiner;
  return camera;
}

// A triangle in the picture. Neighbouring samples mostly show the same one, so the last is kept.
struct Facet {
  std::uint32_t triangle = Samples::kNone;
  Seen corners[3];
  double light = 1;
  double sheen = 0;
};

// `toward`: signed area in the picture, or the normal's component towards the viewer; nullopt if it is zero.
std::optional<Inside> side_of(double toward) {
  if (toward == 0) return std::nullopt;
  return toward > 0 ? Inside::front : Inside::back;
}

// Normal of the side on which corners run counterclockwise, along right, up, toward.
Vec3 normal_of(const Seen (&corners)[3]) {
  const auto edge = [&](int i) {
    return Vec3(corners[i].x - corners[0].x, corners[0].y - corners[i].y, corners[i].depth - corners[0].depth);
  };
  return edge(1).cross(edge(2));
}
Vec3 normal_of(MeshView mesh, const Camera& camera, std::uint32_t triangle) {
  return normal_of({camera.see(mesh.corner(triangle, 0)), camera.see(mesh.corner(triangle, 1)),
                    camera.see(mesh.corner(triangle, 2))});
}

class Painter {
 public:
  Painter(MeshView mesh, const Camera& camera, const Samples& samples, const Paint& paint)
      : mesh_(mesh), camera_(camera), samples_(samples), paint_(paint), points_(is_cloud(mesh)) {}

  // Combines the samples of one pixel. `last`: of the pixel before, by the same thread.
  Pixel pixel(int x, int y, Facet& last) const {
    std::array<double, 3> sum{};
    int covered = 0;
    Known known;
    for (int i = 0; i < kFiner * kFiner; ++i) {
      const int column = kFiner * x + i % kFiner, row = kFiner * y + i / kFiner;
      const std::size_t at = samples_.at(column, row);
      if (samples_.triangle[at] == Samples::kNone) continue;
      ++covered;
      const std::array<double, 3> colour = sample(column, row, at, known, facet_of(samples_.triangle[at], last));
      for (std::size_t k = 0; k < 3; ++k) sum[k] += colour[k];
    }
    Pixel rgba{};
    if (covered == 0) return rgba;
    for (std::size_t k = 0; k < 3; ++k) rgba[k] = to_level(sum[k] / covered);
    rgba[3] = static_cast<std::uint8_t>(255 * covered / (kFiner * kFiner));
    return rgba;
  }

  // The nearest of a pixel's samples.
  float depth_of(int x, int y) const {
    float closest = -std::numeric_limits<float>::infinity();
    for (int i = 0; i < kFiner * kFiner; ++i) {
      closest = std::max(closest, samples_.depth[samples_.at(kFiner * x + i % kFiner, kFiner * y + i / kFiner)]);
    }
    return closest / kFiner;
  }

 private:
  // Distance at a sample of the same pixel; computed again only at a step in depth, or for another point of a cloud.
  struct Known {
    double distance = -1;
    float depth = 0;
    std::uint32_t triangle = Samples::kNone;
  };

  std::array<double, 3> sample(int column, int row, std::size_t at, Known& known, const Facet& facet) const {
    const float depth = samples_.depth[at];
    std::array<double, 3> colour = kGrey;
    if (paint_.distance) {
      const bool other = points_ ? facet.triangle != known.triangle : std::abs(depth - known.depth) > kStep;
      if (known.distance < 0 || other)
        known = {paint_.distance(point_at(facet, column + 0.5, row + 0.5)), depth, facet.triangle};
      colour = coloured(known.distance, column + row);
    }
    const double light = facet.light * (!points_ && outlined(column, row, depth) ? kOutline : 1);
    for (double& channel : colour) channel = (channel + facet.sheen * (255 - channel)) * light;
    return colour;
  }

  // `diagonal`: column and row together, along which stripes run.
  std::array<double, 3> coloured(double distance, int diagonal) const {
    if (paint_.scale.limited && distance > paint_.scale.top && diagonal % kHatchPeriod < kHatchWidth) return kHatch;
    const api::Rgb base = api::colour_of(distance, paint_.scale);
    return {double(base.red), double(base.green), double(base.blue)};
  }

  const Facet& facet_of(std::uint32_t triangle, Facet& facet) const {
    if (facet.triangle == triangle) return facet;
    facet.triangle = triangle;
    for (int i = 0; i < 3; ++i) facet.corners[i] = camera_.see(mesh_.corner(triangle, i));
    set_light(facet, normal_of(facet.corners));
    return facet;
  }

  Vec3 point_at(const Facet& facet, double x, double y) const {
    const Seen(&seen)[3] = facet.corners;
    const double ux = seen[1].x - seen[0].x, uy = seen[1].y - seen[0].y, vx = seen[2].x - seen[0].x,
                 vy = seen[2].y - seen[0].y, px = x - seen[0].x, py = y - seen[0].y;
    const double area = ux * vy - uy * vx;
    double b = area == 0 ? 0 : std::clamp((px * vy - py * vx) / area, 0.0, 1.0);
    double c = area == 0 ? 0 : std::clamp((ux * py - uy * px) / area, 0.0, 1.0);
    if (b + c > 1) c = 1 - b;
    const Vec3& corner = mesh_.corner(facet.triangle, 0);
    return corner + b * (mesh_.corner(facet.triangle, 1) - corner) + c * (mesh_.corner(facet.triangle, 2) - corner);
  }

  // `normal`: along right, up, toward; any length.
  void set_light(Facet& facet, const Vec3& normal) const {
    facet.light = 1, facet.sheen = 0;
    const double length = normal.norm();
    if (!(length > 0)) return;
    if (side_of(normal.z()) == paint_.inside) {
      facet.light = kInside;
      return;
    }
    const double facing = std::max(std::copysign(1.0, normal.z()) * normal.dot(kLight) / length, 0.0);
    facet.light = kAmbient + (1 - kAmbient) * facing;
    facet.sheen = kGlow + kSheen * facing * facing;
  }

  // Whether a neighbour is that much farther away, or empty. A steep surface is no step: there the neighbour on the
  // other side is as much nearer.
  bool outlined(int column, int row, float depth) const {
    return step(column, row, 1, 0, depth) || step(column, row, 0, 1, depth);
  }
  bool step(int column, int row, int dx, int dy, float depth) const {
    const float before = depth_at(column - dx, row - dy), after = depth_at(column + dx, row + dy);
    const float down = depth - std::min(before, after), up = std::max(before, after) - depth;
    return down > kStep && down > 3 * std::max(up, 0.0F);
  }
  float depth_at(int column, int row) const {
    const bool inside = column >= 0 && row >= 0 && column < samples_.width && row < samples_.height;
    return inside ? samples_.depth[samples_.at(column, row)] : std::numeric_limits<float>::infinity();
  }

  const MeshView mesh_;
  const Camera& camera_;
  const Samples& samples_;
  const Paint& paint_;
  const bool points_;  // a cloud, whose points are no steps in depth
};

}  // namespace

Inside inside_of(MeshView mesh, const Camera& camera) {
  const Samples samples = rasterise(mesh, camera);
  std::size_t seen = 0, front = 0;
  std::uint32_t last = Samples::kNone;
  bool is_front = false;
  for (const std::uint32_t triangle : samples.triangle) {
    if (triangle == Samples::kNone) continue;
    if (triangle != last) is_front = side_of(normal_of(mesh, camera, triangle).z()) == Inside::front;
    last = triangle;
    ++seen;
    front += is_front ? 1U : 0U;
  }
  if (front > seen - seen / 4) return Inside::back;
  return front < seen / 4 ? Inside::front : Inside::unknown;
}

Rendered render_with_depth(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool, double cut) {
  const Camera fine = finer(camera);
  const Samples samples = rasterise(mesh, fine, kFiner * cut);
  const Painter painter(mesh, fine, samples, paint);
  Rendered made{{camera.width, camera.height, {}}, {}};
  made.image.rgba.resize(made.image.at(0, camera.height));
  made.depth.resize(made.image.rgba.size() / 4);
  const auto tasks = static_cast<std::size_t>((camera.height + kRowsATask - 1) / kRowsATask);
  pool.run(tasks, [&](std::size_t, std::size_t task) {
    const int first = static_cast<int>(task) * kRowsATask;
    Facet last;
    for (int y = first; y < std::min(first + kRowsATask, camera.height); ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const std::size_t at = made.image.at(x, y);
        const Pixel rgba = painter.pixel(x, y, last);
        std::copy(rgba.begin(), rgba.end(), made.image.rgba.begin() + static_cast<std::ptrdiff_t>(at));
        made.depth[at / 4] = painter.depth_of(x, y);
      }
    }
  });
  return made;
}

Image render(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool, double cut) {
  return render_with_depth(mesh, camera, paint, pool, cut).image;
}

}  // namespace meshgauge::check
