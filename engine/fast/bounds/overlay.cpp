#include "engine/fast/bounds/overlay.h"

#include <algorithm>
#include <bit>

#include "engine/fast/bounds/polygon.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr double kOffset = rounding::kOverlayOffset;
// For the place where an edge is cut, relative to its length: four roundings.
constexpr double kParameterSlack = 8 * rounding::kUnit;

// Limit of the triangles tried around one edge. An edge with more counts as blocked, which is always safe.
constexpr int kMaxAround = 16;

// Whether the piece is wide enough, and its frame good enough.
bool is_fit(const Preparation& piece) {
  return piece.residual <= 32 * rounding::kUnit && piece.triangle.cy > 4 * kOffset;
}

// A vertex of B projected into the piece's plane.
struct Seen {
  Vec2 at;                  // its image
  double off_sq = 0;        // squared distance from the image to the vertex
  unsigned outside_of = 0;  // bit i: surely outside of the piece's side i
};

}  // namespace

// One triangle of B projected into the piece's plane.
struct Overlay::Image {
  std::uint32_t triangle = 0;
  std::array<Seen, 3> corners;
};

// The piece's plane: maps B's triangles into it and points of it back to space.
struct Overlay::View {
  PreparedTriangle frame;
  Polygon piece;
  std::array<HalfPlane, 3> sides;
  Vec2 start = Vec2::Zero();  // y0
  double limit = 0;
  double farthest = 0;  // the bound so far
  const Base* base = nullptr;
  bool takes_cells = false;  // instead of a bound
  std::optional<Vec3> too_far;

  View(const PreparedTriangle& prepared, double most, const Base* above) : frame(prepared), limit(most), base(above) {
    piece = Polygon{Vec2(0, 0), Vec2(frame.length, 0), Vec2(frame.cx, frame.cy)};
    for (std::size_t i = 0; i < 3; ++i) sides[i] = left_of(piece.corners[i], piece.corners[(i + 1) % 3]);
  }

  Vec3 point(const Vec2& x) const { return frame.a + x.x() * frame.e1 + x.y() * frame.e2; }

  Vec2 image_of(const Vec3& p) const {
    const Vec3 ap = p - frame.a;
    return {dot(ap, frame.e1), dot(ap, frame.e2)};
  }

  Seen project(const Vec3& p) const {
    const Vec3 ap = p - frame.a;
    const Vec2 at(dot(ap, frame.e1), dot(ap, frame.e2));
    Seen seen{at, squared_norm(ap - at.x() * frame.e1 - at.y() * frame.e2), 0};
    for (unsigned i = 0; i < 3; ++i) {
      if (sides[i].surely_outside(at, kOffset)) seen.outside_of |= 1U << i;
    }
    return seen;
  }

  Image project(MeshView mesh, std::uint32_t triangle) const {
    Image image{triangle, {}};
    for (std::size_t i = 0; i < 3; ++i) image.corners[i] = project(mesh.corner(triangle, static_cast<int>(i)));
    return image;
  }

  // The inner side of the image's edge. nullopt: the image is too thin to decide.
  static std::optional<HalfPlane> inner_side(const Image& image, std::uint32_t edge) {
    const HalfPlane side = left_of(image.corners[edge].at, image.corners[(edge + 1) % 3].at);
    const Vec2& apex = image.corners[(edge + 2) % 3].at;
    if (side.surely_inside(apex, kOffset)) return side;
    if (side.surely_outside(apex, kOffset)) return side.flipped();
    return std::nullopt;
  }

  // The inner sides of the image's three edges. nullopt: it is too thin to decide.
  static std::optional<std::array<HalfPlane, 3>> inner_sides(const Image& image) {
    std::array<HalfPlane, 3> result;
    for (std::uint32_t edge = 0; edge < 3; ++edge) {
      const auto side = inner_side(image, edge);
      if (!side) return std::nullopt;
      result[edge] = *side;
    }
    return result;
  }

  // The intersection of the piece with the image that has these inner sides, moved outwards by `offset`.
  Polygon common(const std::array<HalfPlane, 3>& inner, double offset) const {
    Polygon polygon = piece;
    for (const HalfPlane& side : inner) clip(polygon, side, offset);
    return polygon;
  }

  // Sets y0 to a point in the image and in the piece. False: they do not surely overlap.
  bool set_start(const Image& image) {
    const auto inner = inner_sides(image);
    if (!inner) return false;
    const auto is_inside = [](const std::array<HalfPlane, 3>& of, const Vec2& x) {
      return of[0].surely_inside(x, kOffset) && of[1].surely_inside(x, kOffset) && of[2].surely_inside(x, kOffset);
    };
    const Vec2 centre_of_image = (image.corners[0].at + image.corners[1].at + image.corners[2].at) / 3;
    for (const Vec2& centre : {piece.centre(), centre_of_image}) {  // mostly one will do
      if (is_inside(*inner, centre) && is_inside(sides, centre)) return start = centre, true;
    }
    Polygon polygon = common(*inner, -kOffset);
    for (const HalfPlane& side : sides) clip(polygon, side, -kOffset);
    if (polygon.size < 3) return false;
    start = polygon.centre();
    return true;
  }

  // Adds the distances of the polygon's corners from the triangle to the bound. False: one exceeds the limit.
  bool add(const PreparedTriangle& triangle, const Polygon& polygon, Work& work) {
    work.triangle_tests += polygon.size;
    for (std::size_t i = 0; i < polygon.size; ++i) {
      const Vec3 p = point(polygon.corners[i]);
      const double distance = norm(p - closest_point(triangle, p));
      farthest = std::max(farthest, base ? distance - (*base)(p) : distance);
      if (farthest > limit) {
        too_far = p;
        return false;
      }
    }
    return true;
  }

  // Adds the whole image to the bound. False: it exceeds the limit, and the bound is unchanged.
  bool add_whole(const Image& image) {
    double most = std::max({image.corners[0].off_sq, image.corners[1].off_sq, image.corners[2].off_sq});
    most = std::sqrt(most);
    if (base) {
      most = 0;
      for (const Seen& corner : image.corners) {
        most = std::max(most, std::sqrt(corner.off_sq) - (*base)(point(corner.at)));
      }
    }
    if (most > limit) return false;
    farthest = std::max(farthest, most);
    return true;
  }

  bool meets_piece(const Seen& a, const Seen& b) const {
    if (a.outside_of & b.outside_of) return false;
    if (a.outside_of == 0 || b.outside_of == 0) return true;
    Interval common;
    for (const HalfPlane& side : sides) common.clip(side, a.at, b.at, kOffset);
    return !common.empty && common.from <= common.to + kParameterSlack;
  }

  // The shadow of the edge a-b: the part of P beyond it, within the wedge from y0. `side`: the inner side of the edge.
  Polygon shadow(const HalfPlane& side, const Vec2& a, const Vec2& b) const {
    Polygon polygon = piece;
    clip(polygon, side.flipped(), kOffset);
    for (const auto& [through, other] : {std::pair(a, b), std::pair(b, a)}) {
      const HalfPlane flank = left_of(start, through);
      if (flank.surely_inside(other, kOffset)) clip(polygon, flank, kOffset);
      if (flank.surely_outside(other, kOffset)) clip(polygon, flank.flipped(), kOffset);
    }
    return polygon;
  }
};

void SeenTriangles::start(std::size_t most) {
  const std::size_t size = std::bit_ceil(2 * most + 2);
  if (entries_.size() < size ||
      ++flood_ == 0) {  // too small, or the counter wrapped around: old entries would count as new
    entries_.assign(std::max(size, entries_.size()), 0);
    flood_ = 1;
  }
}

Overlay::Overlay(const Bvh& target, const Adjacency& adjacency) : target_(target), adjacency_(adjacency) {}

Overlay::~Overlay() = default;

Overlay::Attempt Overlay::attempt(const Piece& piece, std::span<const std::uint32_t> starts, double limit,
                                  std::size_t max_visits, Work& work, const Base* base) {
  const auto& [p0, p1, p2] = piece.corners;
  const Preparation prepared = prepare(p0.point, p1.point, p2.point);
  if (!is_fit(prepared)) return {true, std::nullopt, std::nullopt};

  const double slack = base ? rounding::kOverlayBaseSlack : rounding::kOverlaySlack;
  if (!(limit > slack)) return {true, std::nullopt, std::nullopt};  // the slack alone exceeds it
  View view(prepared.triangle, limit - slack, base);
  if (!start(view, starts, max_visits)) return {};
  if (!flood(view, max_visits, work)) return {true, std::nullopt, view.too_far};
  return {true, view.farthest + slack, std::nullopt};
}

std::optional<Overlay::Cells> Overlay::cells(const Piece& piece, std::span<const std::uint32_t> starts,
                                             std::size_t max_visits, Work& work) {
  const auto& [p0, p1, p2] = piece.corners;
  const Preparation prepared = prepare(p0.point, p1.point, p2.point);
  if (!is_fit(prepared)) return std::nullopt;
  View view(prepared.triangle, 0, nullptr);
  view.takes_cells = true;
  cells_.clear();
  if (!start(view, starts, max_visits) || !flood(view, max_visits, work)) return std::nullopt;
  return Cells{prepared.triangle, cells_};
}

// Opens the first of `starts` that lies over the piece. False: none does.
bool Overlay::start(View& view, std::span<const std::uint32_t> starts, std::size_t max_visits) {
  open_.clear();
  seen_.start(3 * max_visits + 1);  // each visit opens at most three
  for (const std::uint32_t t : starts) {
    if (t == Nearest::kNone) continue;
    const Image image = view.project(target_.mesh(), t);
    if (!view.set_start(image)) continue;
    seen_.add(t);
    open_.push_back(image);
    return true;
  }
  return false;
}

bool Overlay::flood(View& view, std::size_t max_visits, Work& work) {
  for (std::size_t visits = 0; !open_.empty(); ++visits) {
    if (visits == max_visits) return false;
    const Image image = open_.back();
    open_.pop_back();
    if (!visit(view, image, work)) return false;
  }
  return true;
}

// Bounds the part of the piece that the image covers and opens the neighbours. False: the bound fails.
bool Overlay::visit(View& view, const Image& image, Work& work) {
  ++work.triangle_tests;
  const auto inner = View::inner_sides(image);
  if (!inner) return false;
  if (view.takes_cells) cells_.push_back({image.triangle, view.common(*inner, kOffset)});
  const bool whole = view.takes_cells || view.add_whole(image);
  if (!whole && !view.add(target_.prepared(image.triangle), view.common(*inner, kOffset), work)) return false;
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Seen &a = image.corners[edge], &b = image.corners[(edge + 1) % 3];
    const HalfPlane& side = (*inner)[edge];
    if (!view.meets_piece(a, b) || cross(view, image, edge, side)) continue;
    if (side.surely_outside(view.start, kOffset)) continue;  // cannot be crossed outwards
    if (view.takes_cells) return false;
    if (!view.add(target_.prepared(image.triangle), view.shadow(side, a.at, b.at), work)) return false;
  }
  return true;
}

// Opens the first neighbour across the edge that lies beyond it. False: there is none, so the edge is blocked.
bool Overlay::cross(const View& view, const Image& image, std::uint32_t edge, const HalfPlane& side) {
  const MeshView mesh = target_.mesh();
  int tried = 0;
  for (Adjacency::Edge n = adjacency_.next_around(image.triangle, edge);
       (n.triangle != image.triangle || n.edge != edge) && ++tried <= kMaxAround;
       n = adjacency_.next_around(n.triangle, n.edge)) {
    const Vec3& apex = mesh.corner(n.triangle, static_cast<int>((n.edge + 2) % 3));
    if (!side.surely_outside(view.image_of(apex), kOffset)) continue;
    if (seen_.holds(n.triangle)) return true;
    Image next{n.triangle, {}};
    next.corners[n.edge] = image.corners[(edge + 1) % 3];
    next.corners[(n.edge + 1) % 3] = image.corners[edge];
    next.corners[(n.edge + 2) % 3] = view.project(apex);
    if (mesh.corner(n.triangle, static_cast<int>(n.edge)) !=
        mesh.corner(image.triangle, static_cast<int>((edge + 1) % 3))) {
      std::swap(next.corners[n.edge], next.corners[(n.edge + 1) % 3]);  // the two are oriented alike
    }
    seen_.add(n.triangle);
    open_.push_back(next);
    return true;
  }
  return false;
}

}  // namespace meshgauge
