#include "engine/extras/statistics/surface_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

namespace meshgauge {
namespace {

constexpr std::size_t kAskEvery = std::size_t{1} << 14;  // triangles; less than a ms
constexpr int kHalvings = 20;  // of a triangle along its curve: its cells are a millionth of it

// Uniform in [0,1); the same numbers on every platform.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

struct Corners {
  Vec3 a, b, c;  // ab is the longest edge

  Corners(const Vec3& p, const Vec3& q, const Vec3& r) : a(p), b(q), c(r) {
    const double pq = squared_norm(q - p), qr = squared_norm(r - q), rp = squared_norm(p - r);
    if (qr >= pq && qr >= rp) {
      a = q, b = r, c = p;
    } else if (rp > pq) {
      a = r, b = p, c = q;
    }
  }
};

Corners corners_of(MeshView mesh, std::size_t t) { return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}; }

double area_of(const Corners& t) { return is_degenerate(t.a, t.b, t.c) ? 0 : norm((t.b - t.a).cross(t.c - t.a)) / 2; }

// Returns the point at `place` in [0,1) of Sierpinski's curve, which goes from a to b by way of c: through the halves
// on both sides of the line from c to the middle of ab, and so on in each. Both halves have the same area, so a uniform
// place on the curve is a uniform point. Within the cell that `place` leads to the point is drawn at random.
Vec3 on_curve(Corners t, double place, std::mt19937_64& random) {
  for (int i = 0; i < kHalvings; ++i) {
    const Vec3 middle = (t.a + t.b) / 2;
    place *= 2;
    if (place < 1) {
      t.b = t.c;
    } else {
      place -= 1;
      t.a = t.c;
    }
    t.c = middle;
  }
  double x = uniform(random), y = uniform(random);
  if (x + y > 1) x = 1 - x, y = 1 - y;
  return t.a + x * (t.b - t.a) + y * (t.c - t.a);
}

}  // namespace

SurfaceSampler::SurfaceSampler(MeshView mesh, std::size_t strata, Control& control)
    : mesh_(mesh), strata_(strata), ends_(mesh.triangles.size()) {
  if (measure(control, [](const Corners& t) { return area_of(t); })) {
    weight_ = Weight::area;
  } else if (measure(control, [](const Corners& t) { return norm(t.b - t.a); })) {
    weight_ = Weight::length;
  } else {
    measure(control, [](const Corners&) { return 1.0; });
  }
}

// Adds up the lengths of the triangles. False: all are 0, or interrupted.
template <class Length>
bool SurfaceSampler::measure(Control& control, const Length& length) {
  double end = 0;
  for (std::size_t t = 0; t < ends_.size(); ++t) {
    if (t % kAskEvery == 0 && control.check() != Interruption::none) return false;
    ends_[t] = end += length(corners_of(mesh_, t));
  }
  return end > 0;
}

Vec3 SurfaceSampler::point(std::size_t stratum, std::mt19937_64& random) const {
  const double all = ends_.back();
  const double at = (static_cast<double>(stratum) + uniform(random)) / static_cast<double>(strata_) * all;
  // The first triangle that ends after the place; that is never one without length.
  const auto found = std::upper_bound(ends_.begin(), ends_.end(), std::min(at, std::nextafter(all, 0)));
  const auto t = static_cast<std::size_t>(found - ends_.begin());
  const double begin = t == 0 ? 0 : ends_[t - 1];
  const double place = std::clamp((at - begin) / (ends_[t] - begin), 0.0, std::nextafter(1, 0));
  const Corners corners = corners_of(mesh_, t);
  switch (weight_) {
    case Weight::area:
      return on_curve(corners, place, random);
    case Weight::length:
      return corners.a + place * (corners.b - corners.a);
    case Weight::points:
      break;
  }
  return corners.a;
}

}  // namespace meshgauge
