#include "check/html/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <optional>

#include <png.h>
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

Camera finer(Camera camera) {
  camera.width *= kFiner;
  camera.height *= kFiner;
  camera.pixels_per_unit *= kFiner;
  return camera;
}

// The point of a triangle that is visible at a place of the picture, and the surface there.
struct Spot {
  Vec3 point;
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

// 64 levels: a third smaller when compressed, without a visible difference.
std::uint8_t to_level(double channel) {
  return static_cast<std::uint8_t>(std::min(255L, 4 * std::lround(channel / 4)));
}

class Painter {
 public:
  Painter(MeshView mesh, const Camera& camera, const Samples& samples, const Paint& paint)
      : mesh_(mesh), camera_(camera), samples_(samples), paint_(paint), points_(is_cloud(mesh)) {}

  // Combines the samples of one pixel.
  std::array<std::uint8_t, 4> pixel(int x, int y) const {
    std::array<double, 3> sum{};
    int covered = 0;
    Known known;
    for (int i = 0; i < kFiner * kFiner; ++i) {
      const int column = kFiner * x + i % kFiner, row = kFiner * y + i / kFiner;
      const std::size_t at = samples_.at(column, row);
      if (samples_.triangle[at] == Samples::kNone) continue;
      ++covered;
      const std::array<double, 3> colour = sample(column, row, at, known);
      for (std::size_t k = 0; k < 3; ++k) sum[k] += colour[k];
    }
    std::array<std::uint8_t, 4> rgba{};
    if (covered == 0) return rgba;
    for (std::size_t k = 0; k < 3; ++k) rgba[k] = to_level(sum[k] / covered);
    rgba[3] = static_cast<std::uint8_t>(255 * covered / (kFiner * kFiner));
    return rgba;
  }

 private:
  // Distance at a sample of the same pixel; computed again only at a step in depth, or for another point of a cloud.
  struct Known {
    double distance = -1;
    float depth = 0;
    std::uint32_t triangle = Samples::kNone;
  };

  std::array<double, 3> sample(int column, int row, std::size_t at, Known& known) const {
    const Spot spot = spot_at(samples_.triangle[at], column + 0.5, row + 0.5);
    const float depth = samples_.depth[at];
    const std::uint32_t triangle = samples_.triangle[at];
    const bool other = points_ ? triangle != known.triangle : std::abs(depth - known.depth) > kStep;
    if (known.distance < 0 || other) known = {paint_.distance(spot.point), depth, triangle};
    const api::Rgb base = api::colour_of(known.distance, paint_.scale);
    std::array<double, 3> colour{double(base.red), double(base.green), double(base.blue)};
    if (paint_.scale.limited && known.distance > paint_.scale.top && (column + row) % kHatchPeriod < kHatchWidth) {
      colour = kHatch;
    }
    const double light = spot.light * (!points_ && outlined(column, row, depth) ? kOutline : 1);
    for (double& channel : colour) channel = (channel + spot.sheen * (255 - channel)) * light;
    return colour;
  }

  Spot spot_at(std::uint32_t triangle, double x, double y) const {
    Seen seen[3];
    for (int i = 0; i < 3; ++i) seen[i] = camera_.see(mesh_.corner(triangle, i));
    const double ux = seen[1].x - seen[0].x, uy = seen[1].y - seen[0].y, vx = seen[2].x - seen[0].x,
                 vy = seen[2].y - seen[0].y, px = x - seen[0].x, py = y - seen[0].y;
    const double area = ux * vy - uy * vx;
    double b = area == 0 ? 0 : std::clamp((px * vy - py * vx) / area, 0.0, 1.0);
    double c = area == 0 ? 0 : std::clamp((ux * py - uy * px) / area, 0.0, 1.0);
    if (b + c > 1) c = 1 - b;
    const Vec3& corner = mesh_.corner(triangle, 0);
    const Vec3 point = corner + b * (mesh_.corner(triangle, 1) - corner) + c * (mesh_.corner(triangle, 2) - corner);
    return lit(point, normal_of(seen));
  }

  // `normal`: along right, up, toward; any length.
  Spot lit(const Vec3& point, const Vec3& normal) const {
    const double length = normal.norm();
    if (!(length > 0)) return {point, 1, 0};
    if (side_of(normal.z()) == paint_.inside) return {point, kInside, 0};
    const double facing = std::max(std::copysign(1.0, normal.z()) * normal.dot(kLight) / length, 0.0);
    return {point, kAmbient + (1 - kAmbient) * facing, kGlow + kSheen * facing * facing};
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
  for (const std::uint32_t triangle : samples.triangle) {
    if (triangle == Samples::kNone) continue;
    ++seen;
    front += side_of(normal_of(mesh, camera, triangle).z()) == Inside::front ? 1U : 0U;
  }
  if (front > seen - seen / 4) return Inside::back;
  return front < seen / 4 ? Inside::front : Inside::unknown;
}

Image render(MeshView mesh, const Camera& camera, const Paint& paint, ThreadPool& pool, double cut) {
  const Camera fine = finer(camera);
  const Samples samples = rasterise(mesh, fine, kFiner * cut);
  const Painter painter(mesh, fine, samples, paint);
  const auto width = static_cast<std::size_t>(camera.width), height = static_cast<std::size_t>(camera.height);
  Image image{camera.width, camera.height, std::vector<std::uint8_t>(4 * width * height)};
  const auto tasks = static_cast<std::size_t>((camera.height + kRowsATask - 1) / kRowsATask);
  pool.run(tasks, [&](std::size_t, std::size_t task) {
    const int first = static_cast<int>(task) * kRowsATask;
    for (int y = first; y < std::min(first + kRowsATask, camera.height); ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const auto rgba = painter.pixel(x, y);
        std::copy(rgba.begin(), rgba.end(),
                  image.rgba.begin() + 4 * (static_cast<std::ptrdiff_t>(y) * camera.width + x));
      }
    }
  });
  return image;
}

std::vector<std::byte> to_png(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::byte> bytes(size);
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgba.data(), 0, nullptr)) throw std::bad_alloc();
  bytes.resize(size);
  return bytes;
}

}  // namespace meshgauge::check
