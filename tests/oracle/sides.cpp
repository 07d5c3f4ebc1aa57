#include "oracle/sides.h"

#include <algorithm>
#include <cstdint>
#include <queue>
#include <random>
#include <vector>

#include "oracle/long_triangle.h"

namespace meshgauge::oracle {
namespace {

Point direction(std::mt19937_64& random) {
  const auto one = [&random] { return Dyadic(static_cast<double>(random() % 2'000'003) - 1'000'001.0); };
  return {one(), one(), one()};
}

struct Crossing {
  bool is_edge = false;
  bool is_touched = false;
  int sign = 0;
};

Crossing crossing(const Point& p, const Point& d, const Corners& t) {
  const Point a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const int signs[] = {dot(d, cross(a, b)).sign(), dot(d, cross(b, c)).sign(), dot(d, cross(c, a)).sign()};
  const auto [least, most] = std::minmax({signs[0], signs[1], signs[2]});
  if (least < 0 && most > 0) return {};
  if (least == 0 || most == 0) return {true};
  const int towards = dot(a, cross(b, c)).sign() * least;
  if (towards == 0) return {false, true};
  return {false, false, towards > 0 ? least : 0};
}

// Where it meets a ray, it meets it at an edge.
bool is_flat(const Corners& t) {
  const Point normal = cross(t[1] - t[0], t[2] - t[0]);
  return normal.x.sign() == 0 && normal.y.sign() == 0 && normal.z.sign() == 0;
}

bool is_on(const Point& p, const Surface& surface) { return distance_sq(p, surface).numerator.sign() == 0; }

struct SideCell {
  LongTriangle corners;
  long double distance, radius;
  Vec3 centre;
  int side = -1;  // 0: outside, 1: inside, -1: unknown

  long double high() const { return distance + radius; }
  bool operator<(const SideCell& other) const { return high() < other.high(); }
};

class Bracketing {
 public:
  Bracketing(const Mesh& to, long double rounding)
      : to_(long_triangles(to)), exact_(surface_of(to)), rounding_(rounding) {}

  void add(const LongTriangle& t, int side) {
    SideCell cell{t, 0, 0, ((t[0] + t[1] + t[2]) / 3).cast<double>(), side};
    const Point3 centre = cell.centre.cast<long double>();
    cell.distance = to_nearest(centre, to_);
    for (const Point3& corner : t) cell.radius = std::max(cell.radius, (corner - centre).norm());
    const bool is_apart = cell.distance > cell.radius + rounding_;
    if (cell.distance > rounding_ && (is_apart || may_raise(cell))) {
      const int at = side >= 0 ? side : side_at(cell.centre);
      if (at >= 0) low[at] = std::max(low[at], cell.distance);
      if (is_apart) cell.side = at;
    }
    queue_.push(cell);
  }

  bool split() {
    if (queue_.empty()) return false;
    const SideCell cell = queue_.top();
    queue_.pop();
    if (is_done(cell)) return settle(cell), true;
    const LongTriangle& t = cell.corners;
    const Point3 ab = (t[0] + t[1]) / 2, bc = (t[1] + t[2]) / 2, ca = (t[2] + t[0]) / 2;
    for (const LongTriangle& quarter : {LongTriangle{t[0], ab, ca}, LongTriangle{ab, t[1], bc},
                                        LongTriangle{ca, bc, t[2]}, LongTriangle{ab, bc, ca}}) {
      add(quarter, cell.side);
    }
    return true;
  }

  void finish() {
    for (; !queue_.empty(); queue_.pop()) settle(queue_.top());
    for (int side : {0, 1}) high[side] = std::max(high[side], low[side]);
  }

  long double low[2] = {0, 0};
  long double high[2] = {0, 0};
  bool turned = false;

 private:
  bool may_raise(const SideCell& cell) const {
    return cell.side >= 0 ? cell.distance > low[cell.side] : cell.distance > std::min(low[0], low[1]);
  }
  bool is_done(const SideCell& cell) const {
    const auto within = [&](int side) { return cell.high() <= low[side]; };
    return cell.side >= 0 ? within(cell.side) : within(0) && within(1);
  }
  void settle(const SideCell& cell) {
    for (int side : {0, 1}) {
      if (cell.side < 0 || cell.side == side) high[side] = std::max(high[side], cell.high());
    }
  }
  int side_at(const Vec3& p) {
    const auto winding = winding_number(exact(p), exact_);
    turned = turned || winding.value_or(0) < 0;
    return !winding || *winding < 0 ? -1 : *winding > 0 ? 1 : 0;
  }

  std::vector<LongTriangle> to_;
  Surface exact_;
  long double rounding_;
  std::priority_queue<SideCell> queue_;
};

}  // namespace

std::optional<int> winding_number(const Point& p, const Surface& closed) {
  if (is_on(p, closed)) return std::nullopt;
  std::mt19937_64 random(17);
  for (;;) {
    const Point d = direction(random);
    int sum = 0;
    bool is_bad = false;
    for (const Corners& t : closed) {
      if (is_flat(t)) continue;
      const Crossing found = crossing(p, d, t);
      is_bad = is_bad || found.is_edge || found.is_touched;
      sum += found.sign;
    }
    if (!is_bad) return sum;
  }
}

Dyadic volume6(const Surface& closed) {
  Dyadic sum = 0.0;
  for (const Corners& t : closed) sum = sum + dot(t[0], cross(t[1], t[2]));
  return sum;
}

SidesBracket bracket_sides(const Mesh& from, const Mesh& to, std::size_t max_splits, long double rounding) {
  Bracketing bracketing(to, rounding);
  for (const LongTriangle& t : long_triangles(from)) bracketing.add(t, -1);
  for (std::size_t i = 0; i < max_splits && bracketing.split(); ++i) {
  }
  bracketing.finish();
  const auto side = [&](int at) { return SideBracket{bracketing.low[at], bracketing.high[at]}; };
  return {side(0), side(1), bracketing.turned};
}

}  // namespace meshgauge::oracle
