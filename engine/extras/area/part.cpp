#include "engine/extras/area/part.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <Eigen/Geometry>

#include "engine/extras/area/minorant.h"
#include "engine/fast/bounds/lipschitz.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::size_t kMaxVisits = 32;       // of triangles of B by one overlay
constexpr double kLeastCrossing = 1.0 / 64;  // of the other side's height: a smaller side is not worth a part
constexpr double kLeastHeight = 0x1p-40;     // of the frame, over a plane: less may be rounding alone
// Rounded corners may be on alternating sides of a plane, and then a division makes 1.5 times as many (polygon.h).
constexpr std::size_t kMostDivided = 2 * Polygon::kMaxCorners / 3;

double sum(const Linear& f) { return f[0] + f[1] + f[2]; }

PartCut longest_edge(const std::array<Corner, 3>& corners) {
  PartCut best{0, 1, 2};
  double longest = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double length = squared_norm(corners[i].point - corners[j].point);
    if (length > longest) longest = length, best = {i, j, (i + 2) % 3};
  }
  return best;
}

double longest(const std::array<Corner, 3>& corners) {
  const PartCut edge = longest_edge(corners);
  return norm(corners[edge.a].point - corners[edge.b].point);
}

Vec3 point_of(const PreparedTriangle& frame, const Vec2& at) { return frame.a + at.x() * frame.e1 + at.y() * frame.e2; }

// For x = sum w_i p_i, d(x,B) <= sum w_i (d_i + |x - p_i|), where sum w_i |x - p_i| is at most the root of sum w_i |x -
// p_i|^2, which is at most that about the centre m of the smallest circle, sum w_i |m - p_i|^2 <= R^2.
Linear lipschitz(const std::array<Corner, 3>& corners) {
  constexpr double kRoundUp = 1 + 0x1p-47;  // lipschitz.h
  const double radius = kRoundUp * enclosing_radius(corners[0].point, corners[1].point, corners[2].point);
  return {corners[0].distance + radius, corners[1].distance + radius, corners[2].distance + radius};
}

// Where the distance to one owner passes that to the other on the way from a to b, within `resolution`.
double crossing(const PreparedTriangle& of_a, const PreparedTriangle& of_b, const Vec3& a, const Vec3& b,
                double resolution) {
  double low = 0, high = 1;
  while (high - low > resolution) {
    const double middle = (low + high) / 2;
    const Vec3 p = a + middle * (b - a);
    (distance(of_a, p) < distance(of_b, p) ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

double PartBounder::slack_high(std::uint32_t depth) const {
  return rounding::upper_slack(to_.residual(), 0) + rounding::kCutPointSlack * depth + error_;
}

double PartBounder::slack_low(std::uint32_t depth) const {
  return rounding::kMinorantSlack + rounding::kCutPointSlack * depth + error_;
}

// d(x,B) <= d(x,T), which is convex, for the triangle T nearest to a corner.
Linear PartBounder::high_of(const Part& part, bool by_overlay, Work& work) {
  const auto& corners = part.corners;
  Linear best = lipschitz(corners);
  for (std::size_t owner = 0; owner < 3; ++owner) {
    const std::uint32_t slot = corners[owner].slot;
    const bool is_tried = (owner > 0 && slot == corners[0].slot) || (owner > 1 && slot == corners[1].slot);
    if (is_tried) continue;
    const PreparedTriangle triangle = to_.prepared(slot);
    Linear high;
    for (std::size_t i = 0; i < 3; ++i) {
      high[i] = corners[i].slot == slot ? corners[i].distance : distance(triangle, corners[i].point);
    }
    if (sum(high) < sum(best)) best = high;
  }
  const double slack = slack_high(part.depth);
  const double nearest = std::min({corners[0].distance, corners[1].distance, corners[2].distance});
  const bool is_beyond = !limits_.empty() && nearest > limits_.back();  // so is any upper function
  if (by_overlay && !is_beyond && !is_within(best, slack, part, work)) tighten_by_overlay(part, best, work);
  for (double& value : best) value += slack;
  return best;
}

// Whether the part is within the first limit that its corners are within. Lowers `high` where the overlay shows it.
bool PartBounder::is_within(Linear& high, double slack, const Part& part, Work& work) {
  const auto& [a, b, c] = part.corners;
  const double farthest = std::max({a.distance, b.distance, c.distance});
  for (const double limit : limits_) {
    if (farthest + slack > limit) continue;
    if (most(high) + slack <= limit) return true;
    Piece piece;
    piece.corners = part.corners;
    const double most_allowed = limit - slack - 8 * rounding::kUnit;  // less the rounding of the sum
    const auto attempt = overlay_.attempt(piece, std::array{a.slot, b.slot, c.slot}, most_allowed, kMaxVisits, work);
    if (!attempt.upper) return false;
    high = {*attempt.upper, *attempt.upper, *attempt.upper};
    return true;
  }
  return false;
}

// Where several triangles of B lie under the part, none of them bounds it well. The overlay bounds the distance above
// the linear function of the corners' distances.
void PartBounder::tighten_by_overlay(const Part& part, Linear& high, Work& work) {
  constexpr double kLoose = 1.02;  // below that many times the distances, little is to be gained
  const auto& [a, b, c] = part.corners;
  const double distances = a.distance + b.distance + c.distance;
  const double room = (sum(high) - distances) / 3;
  if (sum(high) <= kLoose * distances || room <= 2 * rounding::kOverlayBaseSlack) return;
  const Vec3 x = b.point - a.point, y = c.point - a.point, normal = x.cross(y);
  Overlay::Base base{a.point, a.distance};
  base.slope = ((b.distance - a.distance) * y.cross(normal) + (c.distance - a.distance) * normal.cross(x)) /
               squared_norm(normal);
  if (!(squared_norm(base.slope) <= Overlay::kMostSlope * Overlay::kMostSlope)) return;  // or not a number
  Piece piece;
  piece.corners = part.corners;
  const auto attempt = overlay_.attempt(piece, std::array{a.slot, b.slot, c.slot}, room, kMaxVisits, work, &base);
  if (!attempt.upper) return;
  for (std::size_t i = 0; i < 3; ++i) high[i] = base(part.corners[i].point) + *attempt.upper;
}

Linear PartBounder::high_of_corners(const std::array<Corner, 3>& corners) const {
  Linear high = lipschitz(corners);
  for (double& value : high) value += slack_high(0);
  return high;
}

Part PartBounder::whole(const std::array<Corner, 3>& corners, double weight, bool by_overlay, Work& work) {
  Part part{corners, {}, weight};
  part.enclosure.high = high_of(part, by_overlay, work);
  return part;
}

bool PartBounder::bound_fan_below(std::span<Part> fan, double most, Work& work, const Interrupted* stop) {
  const double slack = slack_low(fan[0].depth), wanted = most + 2 * slack;
  std::array<MinorantPoint, kMostMinorantPoints> points;
  std::size_t size = 0;
  double known = 0;
  const auto add = [&](const Part& part, std::size_t i) {
    const Corner& corner = part.corners[i];
    points[size++] = {corner.point, std::min(corner.distance, wanted), corner.slot};
    known += part.enclosure.low[i] + slack;
  };
  add(fan[0], 0);
  add(fan[0], 1);
  for (const Part& part : fan) add(part, 2);
  const auto found = lower_to_minorant(to_, {points.data(), size}, known, work, stop);
  if (found == MinorantFound::interrupted) return false;
  for (std::size_t i = 0; i < fan.size(); ++i) {
    Part& part = fan[i];
    part.has_low = true;
    const Linear low{points[0].value - slack, points[i + 1].value - slack, points[i + 2].value - slack};
    if (found == MinorantFound::yes && sum(low) > sum(part.enclosure.low)) part.enclosure.low = low;
  }
  return true;
}

// Cuts at a crease of the distance where one crosses an edge, the longest that has one; otherwise bisects the longest
// edge. Any cut is right; these leave parts on which the distance is nearly linear.
PartCut PartBounder::cut_of(const Part& part) const {
  constexpr std::uint32_t kDeepest = 24;  // bisecting is sure to make parts short
  if (part.depth > kDeepest) return longest_edge(part.corners);
  std::array<std::pair<double, std::size_t>, 3> edges;
  for (std::size_t i = 0; i < 3; ++i) {
    edges[i] = {norm(part.corners[(i + 1) % 3].point - part.corners[i].point), i};
  }
  std::sort(edges.begin(), edges.end(), std::greater());
  for (const auto& [length, i] : edges) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    if (const auto at = crease(part.corners[i], part.corners[j], length)) return {i, j, k, *at};
  }
  return longest_edge(part.corners);
}

// Where the owner changes on the way from a to b or, if one owner has nearly all of it, where A crosses the plane of
// that. A change of owner is found to within a share of the distances: nearer to it than that, the other owner's
// distance is as good.
std::optional<double> PartBounder::crease(const Corner& a, const Corner& b, double length) const {
  constexpr double kShare = 1.0 / 8, kFinest = 0x1p-30, kCoarsest = 1.0 / 64;
  constexpr double kLeast = 1.0 / 32;  // nearer to a corner a crossing is not worth a cut
  const PreparedTriangle of_a = to_.prepared(a.slot), of_b = to_.prepared(b.slot);
  const PreparedTriangle* owner = &of_a;
  if (a.slot != b.slot) {
    const double resolution = std::clamp(kShare * std::max(a.distance, b.distance) / length, kFinest, kCoarsest);
    const double at = crossing(of_a, of_b, a.point, b.point, resolution);
    if (at >= 2 * resolution && at <= 1 - 2 * resolution) return at;
    if (at < 0.5) owner = &of_b;
  }
  const Vec3 normal = owner->e1.cross(owner->e2);
  const double above_a = dot(a.point - owner->a, normal), above_b = dot(b.point - owner->a, normal);
  if (above_a * above_b >= 0) return std::nullopt;
  const double at = above_a / (above_a - above_b);
  if (!(at >= kLeast && at <= 1 - kLeast)) return std::nullopt;
  return at;
}

std::optional<std::array<Part, 2>> PartBounder::split(const Part& part, Work& work, const Interrupted* stop) {
  const PartCut cut = cut_of(part);
  const Corner &a = part.corners[cut.a], &b = part.corners[cut.b], &c = part.corners[cut.c];
  ++work.subdivisions;
  const Corner between = nearest_corner(to_, a.point + cut.at * (b.point - a.point), work, stop, a.slot);
  if (!between.complete) return std::nullopt;
  const auto value = [&](const Linear& f) { return f[cut.a] + cut.at * (f[cut.b] - f[cut.a]); };
  std::array<Part, 2> parts;
  for (const bool second : {false, true}) {
    const std::size_t end = second ? cut.b : cut.a;
    Part& half = parts[second ? 1 : 0];
    half.corners = {part.corners[end], between, c};
    half.weight = part.weight * (second ? 1 - cut.at : cut.at);
    half.depth = part.depth + 1;
    half.is_cell = part.is_cell;
    half.is_rough = part.is_rough;
    half.enclosure.high = high_of(half, true, work);
    // The parent's functions hold on the exact part, up to the rounding of the new value.
    const Enclosure& known = part.enclosure;
    const Linear high{known.high[end], value(known.high) + rounding::kCutValueSlack, known.high[cut.c]};
    if (sum(high) < sum(half.enclosure.high)) half.enclosure.high = high;
    half.enclosure.low = {known.low[end], value(known.low) - rounding::kCutValueSlack, known.low[cut.c]};
  }
  return parts;
}

// With F the prepared triangle, the affine map of F onto the exact part keeps shares of areas, and moves no point
// farther than a corner. So a triangle C of F has the share |C| / |F| of the part's weight: R18.
std::optional<CellParts> PartBounder::cells(const Part& part, std::uint64_t most_parts, Work& work) {
  if (part.depth + rounding::kCellLevels >= rounding::kDepthAllowance) return std::nullopt;
  Piece piece;
  piece.corners = part.corners;
  const auto& [a, b, c] = part.corners;
  const auto found = overlay_.cells(piece, std::array{a.slot, b.slot, c.slot}, kMaxVisits, work);
  if (!found || found->cells.size() < 2) return std::nullopt;
  const double whole = found->frame.length * found->frame.cy;  // areas here are doubled
  CellParts made;
  double sum = 0;
  for (const Overlay::Cell& cell : found->cells) sum += add_cell(part, found->frame, cell, whole, made);
  const double error =
      std::abs(sum - whole) + rounding::cell_error(made.fans.size(), made.parts.size(), found->frame.length);
  if (!(error <= most_cell_error_ * whole) || made.parts.size() > most_parts) return std::nullopt;
  work.subdivisions += made.parts.size();
  made.error = part.weight * (error / whole);
  return made;
}

// Adds the parts of a cell, on each side of its triangle's plane. Returns their area.
double PartBounder::add_cell(const Part& part, const PreparedTriangle& frame, const Overlay::Cell& cell, double whole,
                             CellParts& made) const {
  const PreparedTriangle over = to_.prepared(cell.triangle);
  const Vec3 normal = over.e1.cross(over.e2);
  const Polygon& polygon = cell.polygon;
  std::array<double, Polygon::kMaxCorners> heights;
  double highest = 0, lowest = 0;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    heights[i] = dot(point_of(frame, polygon.corners[i]) - over.a, normal);
    highest = std::max(highest, heights[i]), lowest = std::min(lowest, heights[i]);
  }
  const auto add = [&](const Polygon& one) { return add_fan(part, frame, over, {cell.triangle, one}, whole, made); };
  const double lower = std::min(highest, -lowest), higher = std::max(highest, -lowest);
  const bool is_flat = higher <= kLeastHeight * norm(normal) || lower < kLeastCrossing * higher;
  if (is_flat || polygon.size > kMostDivided) return add(polygon);
  Polygon above, below;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const std::size_t next = i + 1 == polygon.size ? 0 : i + 1;
    const double at = heights[i], end = heights[next];
    const Vec2 &x = polygon.corners[i], &y = polygon.corners[next];
    (at >= 0 ? above : below).add(x);
    if ((at >= 0) == (end >= 0)) continue;
    const Vec2 between = x + (at / (at - end)) * (y - x);
    above.add(between);
    below.add(between);
  }
  return add(above) + add(below);
}

// Adds the triangles of a polygon from its first corner. Returns their area.
double PartBounder::add_fan(const Part& part, const PreparedTriangle& frame, const PreparedTriangle& over,
                            const Overlay::Cell& cell, double whole, CellParts& made) const {
  const Polygon& polygon = cell.polygon;
  std::array<Corner, Polygon::kMaxCorners> corners;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const Vec3 p = point_of(frame, polygon.corners[i]);
    corners[i] = {p, distance(over, p), cell.triangle};
  }
  const double low = std::max(least(part.enclosure.low), 0.0);
  double sum = 0;
  for (std::size_t i = 2; i < polygon.size; ++i) {
    const Vec2 x = polygon.corners[i - 1] - polygon.corners[0], y = polygon.corners[i] - polygon.corners[0];
    const double area = std::max(x.x() * y.y() - x.y() * y.x(), 0.0);
    sum += area;
    Part one{{corners[0], corners[i - 1], corners[i]}, {{low, low, low}, {}}, part.weight * (area / whole)};
    one.depth = part.depth + rounding::kCellLevels;
    one.is_cell = one.is_rough = true;
    for (std::size_t k = 0; k < 3; ++k) one.enclosure.high[k] = one.corners[k].distance + slack_high(one.depth);
    made.parts.push_back(one);
  }
  if (polygon.size > 2) made.fans.push_back(made.parts.size());
  return sum;
}

bool PartBounder::measure(Part& part, Work& work, const Interrupted* stop) {
  for (Corner& corner : part.corners) {
    corner = nearest_corner(to_, corner.point, work, stop, corner.slot);
    if (!corner.complete) return false;
  }
  part.is_rough = false;
  const Linear high = high_of(part, true, work);
  if (sum(high) < sum(part.enclosure.high)) part.enclosure.high = high;
  return true;
}

bool PartBounder::can_narrow(const Part& part) const {
  double width = 0;
  for (std::size_t i = 0; i < 3; ++i) width = std::max(width, part.enclosure.high[i] - part.enclosure.low[i]);
  if (width <= floor_of(part)) return false;
  return !part.has_low || can_split(part);
}

bool PartBounder::can_split(const Part& part) const {
  return part.depth < rounding::kDepthAllowance && longest(part.corners) >= rounding::kSmallestPiece;
}

}  // namespace meshgauge
