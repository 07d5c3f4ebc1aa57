#include "engine/mesh/clipping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "engine/mesh/pieces.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

using rounding::kUnit;

constexpr std::size_t kBetweenLooks = std::size_t{1} << 12;
constexpr double kTiny = 0x1p-1060;        // more than lengths near 0 err by
constexpr double kLeastRadius = 0x1p-960;  // a normal of length 1 is found around it
constexpr double kSlack = 32 * kUnit;      // above what a length, its difference and a product err by

enum class Place { inside, outside, unknown };

Place place(std::span<const CutCorner> piece, const Box& box) {
  bool inside = true;
  for (int k = 0; k < 3; ++k) {
    bool above = true, below = true;
    for (const CutCorner& c : piece) {
      const double low = c.at[k] - box.low[k], high = c.at[k] - box.high[k];
      const double off = c.off[k] * (1 + kSlack);
      inside = inside && low >= off && high <= -off;
      above = above && high > off;
      below = below && low < -off;
    }
    if (above || below) return Place::outside;
  }
  return inside ? Place::inside : Place::unknown;
}

Place place(std::span<const CutCorner> piece, const Sphere& sphere) {
  bool inside = true;
  Box box;
  double off = 0;
  for (const CutCorner& c : piece) {
    const double far = scaled_norm(c.at - sphere.centre) * (1 + kSlack) + c.distance_off() + kTiny;
    inside = inside && far * (1 + kSlack) <= sphere.radius;
    box.extend(c.at);
    off = std::max(off, c.distance_off());
  }
  if (inside) return Place::inside;
  const Vec3 nearest = sphere.centre.cwiseMax(box.low).cwiseMin(box.high);
  const double near = scaled_norm(nearest - sphere.centre) * (1 - kSlack) - off - kTiny;
  return near * (1 - kSlack) > sphere.radius ? Place::outside : Place::unknown;
}

// `piece`: of the triangle with this number.
Place place(std::span<const CutCorner> piece, std::uint32_t triangle, const Region& region) {
  if (const auto* group = std::get_if<Group>(&region.shape))
    return group->has(triangle) ? Place::inside : Place::outside;
  const auto* box = std::get_if<Box>(&region.shape);
  return box ? place(piece, *box) : place(piece, std::get<Sphere>(region.shape));
}

// Half-space f of six: x_k <= high, then x_k >= low.
HalfSpace side_of(const Box& box, int f) {
  const int axis = f % 3;
  Plane plane{Vec3::Zero(), f < 3 ? box.high : box.low, 0, axis};
  plane.normal[axis] = f < 3 ? 1 : -1;
  return {plane, plane};
}

// A ball that holds both copies, with what their corners may be off.
struct Ball {
  Vec3 centre;
  double radius = 0;
  double width = 0;  // of the box of `outer`, on its widest axis
  double off = 0;    // the largest of both copies

  explicit Ball(const Pieces& pieces) {
    Box box;
    for (const CutCorner& c : pieces.outer) box.extend(c.at);
    centre = box.low + (box.high - box.low) / 2;
    width = (box.high - box.low).maxCoeff();
    for (const auto* copy : {&pieces.outer, &pieces.inner}) {
      for (const CutCorner& c : *copy)
        radius = std::max(radius, scaled_norm(c.at - centre) * (1 + kSlack) + c.distance_off() + kTiny);
    }
    radius *= 1 + kSlack;
    off = std::max(distance_off(pieces.inner), distance_off(pieces.outer));
  }
};

// The planes of clipping.h. Precondition: radius(ball) <= radius(sphere) / 2, and the ball meets the sphere's surface.
HalfSpace around(const Sphere& sphere, const Ball& ball) {
  const Vec3 to = ball.centre - sphere.centre;
  const double r = sphere.radius, h = ball.radius;
  const double chord = std::sqrt(r - h) * std::sqrt(r + h) * (1 - kSlack);
  const Plane outer{to / scaled_norm(to), sphere.centre, r * (1 + kSlack), -1};
  Plane inner = outer;
  inner.offset = chord;
  return {inner, outer};
}

// Collects triangles as a mesh.
class Collector {
 public:
  Collector(MeshView from, PartMesh& to) : from_(from), to_(to) {}

  void add(std::uint32_t triangle) {
    if (numbers_.empty()) numbers_.assign(from_.positions.size(), kNone);
    Triangle corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = from_.triangles[triangle][i];
      if (numbers_[v] == kNone) numbers_[v] = add(from_.positions[v]);
      corners[i] = numbers_[v];
    }
    add(corners, triangle);
  }

  // As a fan of triangles.
  void add(const Polygon& polygon, std::uint32_t original) {
    if (polygon.empty()) return;
    const auto first = static_cast<std::uint32_t>(to_.mesh.positions.size());
    for (const CutCorner& corner : polygon) add(corner.at);
    const auto last = first + static_cast<std::uint32_t>(polygon.size() - 1);
    for (std::uint32_t i = std::min(first + 1, last); i < last; ++i) add({first, i, i + 1}, original);
    if (polygon.size() < 3) add({first, last, last}, original);
  }

  void err(double error) { to_.error = std::max(to_.error, error); }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t add(const Vec3& position) {
    to_.mesh.positions.push_back(position);
    return static_cast<std::uint32_t>(to_.mesh.positions.size() - 1);
  }
  void add(const Triangle& triangle, std::uint32_t original) {
    to_.mesh.triangles.push_back(triangle);
    to_.original.push_back(original);
  }

  MeshView from_;
  PartMesh& to_;
  std::vector<std::uint32_t> numbers_;  // of the positions of kept triangles
};

// Cuts the triangles that a region's surface may pass through, one after the other.
class Cutter {
 public:
  Cutter(std::span<const Region> regions, Keep keep, double resolution, const Interrupted& interrupted)
      : regions_(regions), keep_(keep), resolution_(resolution), interrupted_(interrupted) {}

  bool stopped() const { return stopped_; }

  // Polls after about as much work as kBetweenLooks pairs of corners are.
  bool is_stopped(const Pieces& pieces) {
    looks_ += pieces.outer.size() * (pieces.inner.size() + 1);
    if (looks_ >= kBetweenLooks) {
      looks_ = 0;
      stopped_ = stopped_ || interrupted_();
    }
    return stopped_;
  }

  // Returns what is left of a triangle: convex parts.
  std::vector<Pieces> cut(std::span<const CutCorner> piece, std::uint32_t triangle) {
    std::vector<Pieces> parts;
    const Polygon whole(piece.begin(), piece.end());
    emit({whole, whole}, parts);
    for (const Region& region : regions_) {
      if (place(piece, triangle, region) == (keep_ == Keep::inside ? Place::inside : Place::outside)) continue;
      std::vector<Pieces> left;
      for (Pieces& part : parts) {
        made_ -= triangles(part);  // what is left of it is counted anew
        const auto* box = std::get_if<Box>(&region.shape);
        box ? cut(std::move(part), *box, left) : cut(part, std::get<Sphere>(region.shape), left);
      }
      parts.swap(left);
    }
    return parts;
  }

 private:
  void emit(Pieces pieces, std::vector<Pieces>& out) {
    if (pieces.outer.empty()) return;
    made_ += triangles(pieces);
    out.push_back(std::move(pieces));
  }

  void cut(Pieces pieces, const Box& box, std::vector<Pieces>& out) {
    if (is_stopped(pieces)) return;
    const Place where = place(pieces.outer, box);
    if (where != Place::unknown) {
      if (where == (keep_ == Keep::inside ? Place::inside : Place::outside)) emit(std::move(pieces), out);
      return;
    }
    if (made_ >= kMostPieces) return emit({{}, std::move(pieces.outer)}, out);
    for (int f = 0; f < 6 && !pieces.outer.empty(); ++f) {
      const HalfSpace side = side_of(box, f);
      if (keep_ == Keep::outside) emit(beyond(pieces, side), out);
      pieces = within(pieces, side);
    }
    if (keep_ == Keep::inside) emit(std::move(pieces), out);
  }

  // Halves the pieces until they are cut as closely as asked, or too small or too many to go on.
  void cut(const Pieces& pieces, const Sphere& sphere, std::vector<Pieces>& out) {
    if (pieces.outer.empty() || is_stopped(pieces)) return;
    const Place where = place(pieces.outer, sphere);
    if (where == Place::inside && keep_ == Keep::inside) return emit(pieces, out);
    if (where == Place::outside && keep_ == Keep::outside) return emit(pieces, out);
    if (where != Place::unknown) return;
    const Ball ball(pieces);
    const bool is_last = ball.width <= std::max(resolution_, 4 * ball.off) || made_ >= kMostPieces;
    if (ball.radius <= sphere.radius / 2 && sphere.radius >= kLeastRadius) {
      const HalfSpace half = around(sphere, ball);
      Pieces cut_once = keep_ == Keep::inside ? within(pieces, half) : beyond(pieces, half);
      if (is_last || gap(cut_once) <= resolution_) return emit(std::move(cut_once), out);
    }
    if (is_last || gap(pieces) > resolution_) return emit({{}, pieces.outer}, out);
    ++made_;
    for (const Pieces& half : divided(pieces)) cut(half, sphere, out);
  }

  static std::size_t triangles(const Pieces& pieces) {
    const auto of = [](const Polygon& copy) {
      return std::min(copy.size(), std::max(copy.size(), std::size_t{3}) - 2);
    };
    return of(pieces.inner) + of(pieces.outer);
  }

  const std::span<const Region> regions_;
  const Keep keep_;
  const double resolution_;
  const Interrupted& interrupted_;
  std::size_t made_ = 0;
  std::size_t looks_ = 0;
  bool stopped_ = false;
};

std::array<CutCorner, 3> piece_of(MeshView mesh, std::size_t triangle, const Vec3& off) {
  return {{{mesh.corner(triangle, 0), off}, {mesh.corner(triangle, 1), off}, {mesh.corner(triangle, 2), off}}};
}

Place kept_place(std::span<const CutCorner> piece, std::uint32_t triangle, std::span<const Region> regions, Keep keep) {
  const Place kept = keep == Keep::inside ? Place::inside : Place::outside;
  bool all = true;
  for (const Region& region : regions) {
    const Place where = place(piece, triangle, region);
    if (where != kept && where != Place::unknown) return Place::outside;
    all = all && where == kept;
  }
  return all ? Place::inside : Place::unknown;
}

}  // namespace

std::optional<RegionPart> part_of(MeshView mesh, double error, std::span<const Region> regions, Keep keep,
                                  double resolution, const Interrupted& interrupted) {
  RegionPart part;
  part.sure.error = part.doubtful.error = error;
  Collector sure(mesh, part.sure), doubtful(mesh, part.doubtful);
  Cutter cutter(regions, keep, resolution, interrupted);
  const Vec3 off = Vec3::Constant(error);
  std::size_t kept = 0;  // of the first triangles: all so far, not collected yet
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if ((t % kBetweenLooks == 0 && interrupted()) || cutter.stopped()) return std::nullopt;
    const std::array piece = piece_of(mesh, t, off);
    const auto number = static_cast<std::uint32_t>(t);
    const Place where = kept_place(piece, number, regions, keep);
    if (where == Place::inside && kept == t) {
      ++kept;
      continue;
    }
    for (std::uint32_t i = 0; kept == t && i < kept; ++i) {
      if (i % kBetweenLooks == 0 && interrupted()) return std::nullopt;
      sure.add(i);
    }
    if (where == Place::inside) sure.add(number);
    if (where != Place::unknown) continue;
    for (const Pieces& pieces : cutter.cut(piece, number)) {
      if (cutter.is_stopped(pieces)) return std::nullopt;
      const double wide = gap(pieces), moved = std::max(distance_off(pieces.inner), distance_off(pieces.outer));
      sure.add(pieces.inner, number);
      sure.err(wide <= resolution ? rounding::add_up(wide, moved) : moved);
      if (wide <= resolution) continue;
      doubtful.add(pieces.outer, number);
      doubtful.err(moved);
    }
  }
  part.whole = kept == mesh.triangles.size();
  return cutter.stopped() ? std::nullopt : std::optional(std::move(part));
}

}  // namespace meshgauge
