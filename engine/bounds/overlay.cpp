#include "engine/bounds/overlay.h"

#include "engine/bounds/polygon.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr double kOffset = rounding::kOverlayOffset;

Polygon polygon_of(const std::array<Vec2, 3>& triangle) {
  return {{triangle[0], triangle[1], triangle[2]}, 3};
}

}  // namespace

// The piece's plane: the images of B's triangles in it, and the way back.
struct Overlay::View {
  PreparedTriangle frame;
  Polygon piece;
  std::array<HalfPlane, 3> sides;
  Vec2 start = Vec2::Zero();  // y0
  double limit = 0;
  double farthest = 0;  // the bound so far

  // One triangle of B, seen in the plane.
  struct Image {
    std::array<Vec2, 3> corners;
    std::array<HalfPlane, 3> sides;  // of edge i, from corner i to i+1, towards the inside
    bool thin = false;               // not trusted: some corner is within kOffset of the opposite side's line
  };

  explicit View(const PreparedTriangle& prepared) : frame(prepared) {
    piece = polygon_of({Vec2(0, 0), Vec2(frame.length, 0), Vec2(frame.cx, frame.cy)});
    for (std::size_t i = 0; i < 3; ++i) sides[i] = left_of(piece.corners[i], piece.corners[(i + 1) % 3]);
  }

  Vec2 image(const Vec3& p) const { return {(p - frame.a).dot(frame.e1), (p - frame.a).dot(frame.e2)}; }
  Vec3 point(const Vec2& x) const { return frame.a + x.x() * frame.e1 + x.y() * frame.e2; }

  Image image(MeshView mesh, std::uint32_t triangle) const {
    Image out;
    for (std::size_t i = 0; i < 3; ++i) out.corners[i] = image(mesh.corner(triangle, static_cast<int>(i)));
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 &a = out.corners[i], &b = out.corners[(i + 1) % 3];
      if (a == b) {
        out.thin = true;
        return out;
      }
      out.sides[i] = left_of(a, b);
      const double apex = out.sides[i].distance(out.corners[(i + 2) % 3]);
      if (apex < 0) out.sides[i] = out.sides[i].flipped();
      out.thin = out.thin || std::abs(apex) <= kOffset;
    }
    return out;
  }

  Polygon common(const Image& image, double offset) const {
    Polygon polygon = piece;
    for (const HalfPlane& side : image.sides) polygon = clip(polygon, side, offset);
    return polygon;
  }

  // A point that is surely in both, if there is one.
  bool set_start(const Image& image) {
    Polygon polygon = common(image, -kOffset);
    for (const HalfPlane& side : sides) polygon = clip(polygon, side, -kOffset);
    if (polygon.size < 3) return false;
    start = polygon.centre();
    return true;
  }

  double farthest_from(const PreparedTriangle& triangle, const Polygon& polygon, Work& work) const {
    double most = 0;
    work.triangle_tests += polygon.size;
    for (std::size_t i = 0; i < polygon.size && most <= limit; ++i) {
      most = std::max(most, distance(triangle, point(polygon.corners[i])));
    }
    return most;
  }

  bool meets_piece(const Vec2& a, const Vec2& b) const {
    Polygon edge{{a, b}, 2};
    for (const HalfPlane& side : sides) edge = clip(edge, side, kOffset);
    return edge.size > 0;
  }

  // P beyond the edge a-b with inside `side`, within the wedge from y0.
  Polygon shadow(const HalfPlane& side, const Vec2& a, const Vec2& b) const {
    Polygon polygon = clip(piece, side.flipped(), kOffset);
    for (const auto& [through, other] : {std::pair(a, b), std::pair(b, a)}) {
      if (through == start) continue;
      HalfPlane flank = left_of(start, through);
      const double where = flank.distance(other);
      if (std::abs(where) <= kOffset) continue;
      polygon = clip(polygon, where > 0 ? flank : flank.flipped(), kOffset);
    }
    return polygon;
  }
};

Overlay::Overlay(const Bvh& target)
    : target_(target),
      adjacency_(target.mesh()),
      slot_of_(target.mesh().triangles.size()),
      visited_in_(target.mesh().triangles.size(), 0) {
  for (std::uint32_t slot = 0; slot < slot_of_.size(); ++slot) slot_of_[target.triangle(slot)] = slot;
}

std::optional<double> Overlay::upper(const Piece& piece, double limit, std::size_t max_visits, Work& work) {
  const auto& [p0, p1, p2] = piece.corners;
  const Preparation prepared = prepare(p0.point, p1.point, p2.point);
  if (prepared.residual > 32 * rounding::kUnit || prepared.triangle.cy <= 4 * kOffset) return std::nullopt;

  View view(prepared.triangle);
  view.limit = limit - rounding::kOverlaySlack;
  open_.clear();
  ++flood_;
  for (const Corner& corner : piece.corners) {
    const std::uint32_t t = target_.triangle(corner.slot);
    const View::Image image = view.image(target_.mesh(), t);
    if (image.thin || !view.set_start(image)) continue;
    visited_in_[t] = flood_;
    open_.push_back(t);
    break;
  }
  if (open_.empty()) return std::nullopt;

  std::size_t visits = 0;
  while (!open_.empty()) {
    if (++visits > max_visits) return std::nullopt;
    const std::uint32_t t = open_.back();
    open_.pop_back();
    if (!visit(view, t, work)) return std::nullopt;
  }
  return view.farthest + rounding::kOverlaySlack;
}

// Bounds the part of the piece that t lies over, and goes on to its neighbours. False: the bound fails.
bool Overlay::visit(View& view, std::uint32_t t, Work& work) {
  const MeshView mesh = target_.mesh();
  const PreparedTriangle& triangle = target_.prepared(slot_of_[t]);
  const View::Image image = view.image(mesh, t);
  if (image.thin) return false;
  view.farthest = std::max(view.farthest, view.farthest_from(triangle, view.common(image, kOffset), work));
  if (view.farthest > view.limit) return false;

  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Vec2 &a = image.corners[edge], &b = image.corners[(edge + 1) % 3];
    const HalfPlane& side = image.sides[edge];
    if (!view.meets_piece(a, b) || cross(view, t, edge, side)) continue;
    if (side.distance(view.start) < -kOffset) continue;  // cannot be crossed outwards
    view.farthest = std::max(view.farthest, view.farthest_from(triangle, view.shadow(side, a, b), work));
    if (view.farthest > view.limit) return false;
  }
  return true;
}

// Goes into the first neighbour across t's edge that lies beyond it. False: there is none, the edge is blocked.
bool Overlay::cross(const View& view, std::uint32_t t, std::uint32_t edge, const HalfPlane& side) {
  for (Adjacency::Edge n = adjacency_.next_around(t, edge); n.triangle != t || n.edge != edge;
       n = adjacency_.next_around(n.triangle, n.edge)) {
    const Vec2 apex = view.image(target_.mesh().corner(n.triangle, static_cast<int>((n.edge + 2) % 3)));
    if (!(side.distance(apex) < -kOffset)) continue;
    if (visited_in_[n.triangle] != flood_) {
      visited_in_[n.triangle] = flood_;
      open_.push_back(n.triangle);
    }
    return true;
  }
  return false;
}

}  // namespace meshgauge
