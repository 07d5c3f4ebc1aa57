#include "check/html/camera.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace meshgauge::check {
namespace {

constexpr double kMargin = 0.06;  // share of the picture, on each side

View looking_from(const Vec3& toward, int up) {
  const Vec3 upright = up == 1 ? Vec3::UnitY() : Vec3::UnitZ();
  const Vec3 aside = up == 1 ? Vec3::UnitZ() : Vec3::UnitY();
  View view;
  view.toward = toward.normalized();
  const Vec3 right = upright.cross(view.toward);
  view.right = (right.norm() > 1e-6 ? right : aside.cross(view.toward)).normalized();
  view.up = view.toward.cross(view.right);
  return view;
}

Vec3 size_of(MeshView mesh, const Frame& frame) {
  const Box box = bounding_box(mesh);
  return frame.to_frame(box.high) - frame.to_frame(box.low);
}

struct Candidate {
  View view;
  double score = 0;
};

// Height above the horizon, in degrees, and its preference.
struct Elevation {
  double degrees;
  double liking;
};
constexpr Elevation kElevations[] = {{28, 1}, {55, 0.8}, {4, 0.5}, {-28, 0.45}, {-55, 0.2}};
constexpr int kAround = 12;

// Area of the box's outline as seen along `toward`.
double box_area(const Vec3& size, const Vec3& toward) {
  return size.y() * size.z() * std::abs(toward.x()) + size.x() * size.z() * std::abs(toward.y()) +
         size.x() * size.y() * std::abs(toward.z());
}

std::vector<Candidate> views_around(int up) {
  const double radian = std::acos(-1.0) / 180;
  std::vector<Candidate> views;
  for (const Elevation& elevation : kElevations) {
    for (int i = 0; i < kAround; ++i) {
      // Half a step off the axes, so that a box shows three faces. The first views are from the front.
      const double azimuth = (-52.5 + 30 * i) * radian, height = elevation.degrees * radian;
      const Vec3 z_up(std::cos(height) * std::cos(azimuth), std::cos(height) * std::sin(azimuth), std::sin(height));
      const Vec3 toward = up == 1 ? Vec3(z_up.x(), z_up.z(), -z_up.y()) : z_up;
      views.push_back({looking_from(toward, up), 0.2 * elevation.liking});
    }
  }
  views.push_back({looking_from(up == 1 ? Vec3::UnitY() : Vec3::UnitZ(), up), 0.05});
  views.push_back({looking_from(up == 1 ? Vec3(-Vec3::UnitY()) : Vec3(-Vec3::UnitZ()), up), 0});
  return views;
}

void add_scores(std::vector<Candidate>& views, const Vec3& size, const Vec3& normal) {
  double largest = 0;
  for (const Candidate& each : views) largest = std::max(largest, box_area(size, each.view.toward));
  for (Candidate& each : views) {
    if (largest > 0) each.score += 0.4 * box_area(size, each.view.toward) / largest;
    each.score += 0.4 * std::abs(normal.dot(each.view.toward));
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
}

// Whether the triangle lies between the origin and a viewer in direction `view.toward`. A triangle through the
// origin, such as the point's own, does not count.
bool covers(const View& view, const Vec3 (&corners)[3], double slack) {
  double x[3], y[3];
  for (int i = 0; i < 3; ++i) x[i] = corners[i].dot(view.right);
  if ((x[0] > 0 && x[1] > 0 && x[2] > 0) || (x[0] < 0 && x[1] < 0 && x[2] < 0)) return false;
  for (int i = 0; i < 3; ++i) y[i] = corners[i].dot(view.up);
  const double c = x[0] * y[1] - x[1] * y[0], a = x[1] * y[2] - x[2] * y[1], b = x[2] * y[0] - x[0] * y[2];
  if (!((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0))) return false;
  const double area = a + b + c;
  if (area == 0) return false;
  const Vec3 hit = (a * corners[0] + b * corners[1] + c * corners[2]) / area;
  return hit.dot(view.toward) > slack;
}

// Removes views in which something covers the point.
void keep_open(std::vector<Candidate>& views, MeshView mesh, const Frame& frame, const Vec3& point) {
  const Vec3 origin = frame.to_frame(point);
  const double slack = 1e-5 * size_of(mesh, frame).norm();
  for (const Triangle& triangle : mesh.triangles) {
    if (views.empty()) return;
    const Vec3 corners[3] = {frame.to_frame(mesh.positions[triangle[0]]) - origin,
                             frame.to_frame(mesh.positions[triangle[1]]) - origin,
                             frame.to_frame(mesh.positions[triangle[2]]) - origin};
    std::erase_if(views, [&](const Candidate& each) { return covers(each.view, corners, slack); });
  }
}

}  // namespace

double Camera::pixel_size() const { return std::ldexp(1 / pixels_per_unit, frame.exponent()); }

ChosenView choose_view(const Sight& first, const std::optional<Sight>& second, const Frame& frame, const Vec3& normal,
                       int up) {
  std::vector<Candidate> views = views_around(up);
  add_scores(views, size_of(first.mesh, frame), normal);
  const ChosenView any{views.front().view, true};
  keep_open(views, first.mesh, frame, first.point);
  if (views.empty()) return any;
  const ChosenView open{views.front().view, false};
  if (second) keep_open(views, second->mesh, frame, second->point);
  return views.empty() ? open : ChosenView{views.front().view, false};
}

bool covered(MeshView mesh, const Frame& frame, const View& view, const Vec3& point) {
  std::vector<Candidate> one{{view, 0}};
  keep_open(one, mesh, frame, point);
  return one.empty();
}

Camera whole_view(MeshView mesh, const Frame& frame, const View& view, std::span<const Vec3> points, int width,
                  int height) {
  return common_view(std::span(&mesh, 1), frame, view, points, width, height);
}

Camera common_view(std::span<const MeshView> meshes, const Frame& frame, const View& view, std::span<const Vec3> points,
                   int width, int height) {
  Box seen;  // along the axes of the picture
  const auto extend = [&](const Vec3& p) {
    const Vec3 q = frame.to_frame(p);
    seen.extend(Vec3(q.dot(view.right), q.dot(view.up), q.dot(view.toward)));
  };
  for (const MeshView& mesh : meshes) {
    for (const Triangle& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) extend(mesh.positions[corner]);
    }
  }
  for (const Vec3& p : points) extend(p);

  const Vec3 middle = 0.5 * (seen.low + seen.high), size = seen.high - seen.low;
  Camera camera{frame, view,  middle.x() * view.right + middle.y() * view.up + middle.z() * view.toward,
                1,     width, height};
  const double room = 1 - 2 * kMargin;
  // limits the magnification of a mesh that is seen as one point
  const double least = 1e-9;
  camera.pixels_per_unit = room * std::min(width / std::max(size.x(), least), height / std::max(size.y(), least));
  return camera;
}

Camera close_view(const Camera& whole, const Vec3& centre, double reach, int width, int height) {
  Camera camera = whole;
  camera.centre = whole.frame.to_frame(centre);
  camera.pixels_per_unit = 0.5 * std::min(width, height) / whole.frame.length_to_frame(reach);
  camera.width = width;
  camera.height = height;
  return camera;
}

}  // namespace meshgauge::check
