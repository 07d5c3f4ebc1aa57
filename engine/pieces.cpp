#include "engine/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

using rounding::kUnit;

constexpr std::size_t kMostCompared = std::size_t{1} << 10;  // pairs of triangles

// The end of an axis-parallel edge, or a coordinate that the plane fixes, is exact: nothing is added to `off`.
Corner crossing(const Corner& a, const Corner& b, double height_a, double height_b, const Plane& plane) {
  const double t = height_a / (height_a - height_b);
  Corner corner;
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

enum class Edge { kept, left_out };  // whether a triangle with no corner below the plane keeps what touches it

// Appends the part of `piece` where the heights are at most 0.
void cut(const Piece& piece, const std::array<double, 3>& heights, const Plane& plane, Edge edge,
         std::vector<Piece>& out) {
  const auto [least, most] = std::minmax({heights[0], heights[1], heights[2]});
  if (edge == Edge::kept ? least > 0 : least >= 0) return;
  if (most <= 0) return out.push_back(piece);
  std::array<Corner, 4> corners;
  std::size_t size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    if (heights[i] <= 0) corners[size++] = piece[i];
    if (heights[i] < 0 && heights[next] > 0)
      corners[size++] = crossing(piece[i], piece[next], heights[i], heights[next], plane);
    if (heights[i] > 0 && heights[next] < 0)
      corners[size++] = crossing(piece[next], piece[i], heights[next], heights[i], plane);
  }
  const auto corner = [&](std::size_t i) { return corners[std::min(i, size - 1)]; };
  out.push_back({corner(0), corner(1), corner(2)});
  if (size == 4) out.push_back({corners[0], corners[2], corners[3]});
}

// Cuts by sign * height + shift * height_off <= 0.
std::vector<Piece> cut_all(const std::vector<Piece>& pieces, const Plane& plane, double sign, double shift, Edge edge) {
  std::vector<Piece> out;
  out.reserve(pieces.size() + 1);
  for (const Piece& piece : pieces) {
    std::array<double, 3> heights;
    for (std::size_t i = 0; i < 3; ++i) {
      heights[i] = sign * plane.height(piece[i].at);
      if (shift != 0) heights[i] += shift * plane.height_off(piece[i]);
    }
    cut(piece, heights, plane, edge, out);
  }
  return out;
}

bool are_equal(const Pieces& pieces) {
  const auto same = [](const Corner& a, const Corner& b) { return a.at == b.at && a.off == b.off; };
  return std::ranges::equal(pieces.inner, pieces.outer,
                            [&](const Piece& a, const Piece& b) { return std::ranges::equal(a, b, same); });
}

// Two halves of a triangle, at its longest edge.
std::array<Piece, 2> halves(const Piece& piece) {
  std::size_t longest = 0;
  std::array<double, 3> lengths;
  for (std::size_t i = 0; i < 3; ++i) lengths[i] = length_of(piece[(i + 1) % 3].at - piece[i].at);
  for (std::size_t i = 1; i < 3; ++i) longest = lengths[i] > lengths[longest] ? i : longest;
  const Corner &a = piece[longest], &b = piece[(longest + 1) % 3], &c = piece[(longest + 2) % 3];
  const Corner middle = crossing(a, b, -1, 1, Plane{});
  return {{{a, middle, c}, {middle, b, c}}};
}

std::vector<Pieces> halves(const Pieces& pieces) {
  Box box;
  for (const Piece& piece : pieces.outer) {
    for (const Corner& corner : piece) box.extend(corner.at);
  }
  Plane plane{Vec3::Zero(), box.low + (box.high - box.low) / 2};
  (box.high - box.low).maxCoeff(&plane.axis);
  plane.normal[plane.axis] = 1;
  return {{cut_all(pieces.inner, plane, 1, 0, Edge::kept), cut_all(pieces.outer, plane, 1, 0, Edge::kept)},
          {cut_all(pieces.inner, plane, -1, 0, Edge::left_out), cut_all(pieces.outer, plane, -1, 0, Edge::left_out)}};
}

}  // namespace

double length_of(const Vec3& v) {
  const double most = v.cwiseAbs().maxCoeff();
  return most > 0 ? most * (v / most).norm() : 0;
}

double Corner::distance_off() const {
  return off.isZero(0) ? 0 : rounding::add_up(off[0], rounding::add_up(off[1], off[2]));
}

double Plane::height(const Vec3& x) const {
  return axis >= 0 ? normal[axis] * (x[axis] - origin[axis]) : normal.dot(x - origin) - offset;
}

double Plane::height_off(const Corner& corner) const {
  if (axis >= 0) {
    const double off = corner.off[axis];
    return off == 0 ? 0 : rounding::height_error(off, std::abs(corner.at[axis] - origin[axis]));
  }
  return rounding::height_error(corner.distance_off(), (corner.at - origin).lpNorm<1>() + std::abs(offset));
}

Pieces within(const Pieces& pieces, const HalfSpace& half) {
  return {cut_all(pieces.inner, half.inner, 1, 1, Edge::kept), cut_all(pieces.outer, half.outer, 1, -1, Edge::kept)};
}

Pieces beyond(const Pieces& pieces, const HalfSpace& half) {
  return {cut_all(pieces.inner, half.outer, -1, 1, Edge::left_out),
          cut_all(pieces.outer, half.inner, -1, -1, Edge::left_out)};
}

std::vector<Pieces> divided(const Pieces& pieces) {
  if (!are_equal(pieces)) return halves(pieces);
  std::vector<Pieces> parts;
  if (pieces.outer.size() == 1) {
    for (const Piece& half : halves(pieces.outer[0])) parts.push_back({{half}, {half}});
  } else {
    for (const Piece& piece : pieces.outer) parts.push_back({{piece}, {piece}});
  }
  return parts;
}

double gap(const Pieces& pieces) {
  if (are_equal(pieces)) return 0;
  if (pieces.outer.size() * pieces.inner.size() > kMostCompared) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (const Piece& piece : pieces.outer) {
    for (const Corner& corner : piece) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Piece& other : pieces.inner) {
        for (const Corner& to : other) nearest = std::min(nearest, length_of(corner.at - to.at));
      }
      largest = std::max(largest, nearest);
    }
  }
  return largest * (1 + 16 * kUnit);
}

double distance_off(const Pieces& pieces) {
  double largest = 0;
  for (const auto* copy : {&pieces.inner, &pieces.outer}) {
    for (const Piece& piece : *copy) {
      for (const Corner& corner : piece) largest = std::max(largest, corner.distance_off());
    }
  }
  return largest;
}

}  // namespace meshgauge
