#include "engine/mesh/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

using rounding::kUnit;

// The end of an axis-parallel edge, or a coordinate that the plane fixes, is exact: nothing is added to `off`.
CutCorner crossing(const CutCorner& a, const CutCorner& b, double height_a, double height_b, const Plane& plane) {
  const double t = height_a / (height_a - height_b);
  CutCorner corner;
  for (int k = 0; k < 3; ++k) {
    const double from = a.at[k], to = b.at[k];
    corner.off[k] = std::max(a.off[k], b.off[k]);
    if (k == plane.axis && corner.off[k] == 0) {
      corner.at[k] = plane.origin[k];
      continue;
    }
    corner.at[k] = std::clamp(from + t * (to - from), std::min(from, to), std::max(from, to));
    if (from != to) corner.off[k] = rounding::add_up(corner.off[k], rounding::crossing_error(from, to));
  }
  return corner;
}

enum class Edge { kept, left_out };  // whether a polygon with no corner below the plane keeps what touches it
enum class Copy { inner, outer };

// Cuts by g = sign * height + shift * height_off: an inner copy keeps the corners around the lowest one that follow
// each other with g <= 0, an outer copy leaves out those around the highest one with g > 0. They are the same corners
// unless rounding has made g change its sign more than twice.
Polygon cut(const Polygon& polygon, const Plane& plane, double sign, double shift, Edge edge, Copy copy) {
  const std::size_t size = polygon.size();
  if (size == 0) return {};
  std::vector<double> g(size);
  for (std::size_t i = 0; i < size; ++i) {
    g[i] = sign * plane.height(polygon[i].at);
    if (shift != 0) g[i] += shift * plane.height_off(polygon[i]);
  }
  const auto [least, most] = std::ranges::minmax_element(g);
  if (edge == Edge::kept ? *least > 0 : *least >= 0) return {};
  if (*most <= 0) return polygon;
  const auto next = [&](std::size_t i) { return i + 1 == size ? 0 : i + 1; };
  const auto before = [&](std::size_t i) { return (i == 0 ? size : i) - 1; };
  std::size_t first = static_cast<std::size_t>((copy == Copy::inner ? least : most) - g.begin()), last = first;
  if (copy == Copy::inner) {
    while (g[before(first)] <= 0) first = before(first);
    while (g[next(last)] <= 0) last = next(last);
  } else {
    while (g[first] > 0) first = next(first);
    while (g[last] > 0) last = before(last);
  }
  const auto crossed = [&](std::size_t a, std::size_t b) {
    return crossing(polygon[a], polygon[b], g[a], g[b], plane);
  };
  Polygon out;
  out.reserve(size + 1);
  if (g[first] < 0) out.push_back(crossed(first, before(first)));
  for (std::size_t i = first; i != last; i = next(i)) out.push_back(polygon[i]);
  out.push_back(polygon[last]);
  if (g[last] < 0) out.push_back(crossed(last, next(last)));
  return out;
}

bool are_equal(const Pieces& pieces) {
  return std::ranges::equal(pieces.inner, pieces.outer,
                            [](const CutCorner& a, const CutCorner& b) { return a.at == b.at && a.off == b.off; });
}

// Two halves of a triangle, at its longest edge.
std::vector<Pieces> halves(const Polygon& triangle) {
  std::size_t longest = 0;
  std::array<double, 3> lengths;
  for (std::size_t i = 0; i < 3; ++i) lengths[i] = scaled_norm(triangle[(i + 1) % 3].at - triangle[i].at);
  for (std::size_t i = 1; i < 3; ++i) longest = lengths[i] > lengths[longest] ? i : longest;
  const CutCorner &a = triangle[longest], &b = triangle[(longest + 1) % 3], &c = triangle[(longest + 2) % 3];
  const CutCorner middle = crossing(a, b, -1, 1, Plane{});
  const Polygon first{a, middle, c}, second{middle, b, c};
  return {{first, first}, {second, second}};
}

std::vector<Pieces> halves(const Pieces& pieces) {
  Box box;
  for (const CutCorner& corner : pieces.outer) box.extend(corner.at);
  Plane plane{Vec3::Zero(), box.low + (box.high - box.low) / 2};
  (box.high - box.low).maxCoeff(&plane.axis);
  plane.normal[plane.axis] = 1;
  const auto half = [&](double sign, Edge edge) {
    return Pieces{cut(pieces.inner, plane, sign, 0, edge, Copy::inner),
                  cut(pieces.outer, plane, sign, 0, edge, Copy::outer)};
  };
  return {half(1, Edge::kept), half(-1, Edge::left_out)};
}

}  // namespace

double CutCorner::distance_off() const {
  return off.isZero(0) ? 0 : rounding::add_up(off[0], rounding::add_up(off[1], off[2]));
}

double Plane::height(const Vec3& x) const {
  return axis >= 0 ? normal[axis] * (x[axis] - origin[axis]) : dot(normal, x - origin) - offset;
}

double Plane::height_off(const CutCorner& corner) const {
  if (axis >= 0) {
    const double off = corner.off[axis];
    return off == 0 ? 0 : rounding::height_error(off, std::abs(corner.at[axis] - origin[axis]));
  }
  const double span = dot((corner.at - origin).cwiseAbs(), Vec3::Ones());
  return rounding::height_error(corner.distance_off(), span + std::abs(offset));
}

Pieces within(const Pieces& pieces, const HalfSpace& half) {
  return {cut(pieces.inner, half.inner, 1, 1, Edge::kept, Copy::inner),
          cut(pieces.outer, half.outer, 1, -1, Edge::kept, Copy::outer)};
}

Pieces beyond(const Pieces& pieces, const HalfSpace& half) {
  return {cut(pieces.inner, half.outer, -1, 1, Edge::left_out, Copy::inner),
          cut(pieces.outer, half.inner, -1, -1, Edge::left_out, Copy::outer)};
}

std::vector<Pieces> divided(const Pieces& pieces) {
  if (pieces.outer.size() < 3 || !are_equal(pieces)) return halves(pieces);
  if (pieces.outer.size() == 3) return halves(pieces.outer);
  std::vector<Pieces> parts;
  for (std::size_t i = 2; i < pieces.outer.size(); ++i) {
    const Polygon triangle{pieces.outer[0], pieces.outer[i - 1], pieces.outer[i]};
    parts.push_back({triangle, triangle});
  }
  return parts;
}

double distance_off(const Polygon& polygon) {
  double largest = 0;
  for (const CutCorner& corner : polygon) largest = std::max(largest, corner.distance_off());
  return largest;
}

double gap(const Pieces& pieces) {
  if (are_equal(pieces)) return 0;
  double largest = 0;
  for (const CutCorner& corner : pieces.outer) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const CutCorner& to : pieces.inner) nearest = std::min(nearest, scaled_norm(corner.at - to.at));
    largest = std::max(largest, nearest);
  }
  if (pieces.inner.size() > 3) largest = rounding::add_up(largest, 2 * distance_off(pieces.inner));
  return largest * (1 + 16 * kUnit);
}

}  // namespace meshgauge
