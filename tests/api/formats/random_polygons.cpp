#include "tests/api/formats/random_polygons.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace meshgauge::api::test {
namespace {

using fuzz::Dice;

constexpr std::int64_t kStep = 12;

const GridPoint& after(const Outline& outline, std::size_t i) { return outline[(i + 1) % outline.size()]; }

// Returns true when edges share no points except corners of neighbours.
bool is_simple(const Outline& outline) {
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const GridPoint &a = outline[i], &b = after(outline, i);
    if (a == b || on_segment(after(outline, i + 1), a, b) || on_segment(a, b, after(outline, i + 1))) return false;
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const GridPoint &c = outline[j], &d = after(outline, j);
      if (cross_inside(a, b, c, d) || on_segment(c, a, b) || on_segment(d, a, b) || on_segment(a, c, d)) return false;
    }
  }
  return n >= 3;
}

GridPoint at_angle(double angle, double radius) {
  return {kStep * std::llround(radius * std::cos(angle)), kStep * std::llround(radius * std::sin(angle))};
}

Outline around(Dice& dice, double least_radius, double largest_radius) {
  const int n = dice.between(3, 24);
  std::vector<double> angles;
  for (int i = 0; i < n; ++i) angles.push_back(dice.uniform(0, 2 * std::numbers::pi));
  std::sort(angles.begin(), angles.end());
  Outline outline;
  for (const double angle : angles) outline.push_back(at_angle(angle, dice.uniform(least_radius, largest_radius)));
  return outline;
}

// Without corners on its edges.
Outline hull(Outline points) {
  std::sort(points.begin(), points.end(),
            [](const GridPoint& a, const GridPoint& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  Outline hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = hull.size();
    for (const GridPoint& p : points) {
      while (hull.size() >= begin + 2 && twice_area(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Random points, joined at random; crossing edges are exchanged until there are none.
Outline tangled(Dice& dice) {
  const int n = dice.between(4, 14), side = dice.chance(0.5) ? 4 : 500;
  Outline outline;
  for (int i = 0; i < n; ++i) outline.push_back({kStep * dice.between(0, side), kStep * dice.between(0, side)});
  for (int round = 0; round < 200; ++round) {
    bool any = false;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      for (std::size_t j = i + 2; j < outline.size(); ++j) {
        if (!cross_inside(outline[i], after(outline, i), outline[j], after(outline, j))) continue;
        std::reverse(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                     outline.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        any = true;
      }
    }
    if (!any) break;
  }
  return outline;
}

Outline comb(Dice& dice) {
  const int teeth = dice.between(1, 8);
  Outline outline = {{kStep * 4 * teeth, 0}, {kStep * 4 * teeth, kStep * 20}};
  for (int i = teeth; i-- > 0;) {
    const int depth = dice.between(1, 19), height = dice.between(depth + 1, 25);
    outline.push_back({kStep * (4 * i + dice.between(2, 3)), kStep * depth});
    if (dice.chance(0.5)) outline.push_back({kStep * (4 * i + 1), kStep * depth});
    outline.push_back({kStep * 4 * i, kStep * height});
  }
  outline.push_back({0, 0});
  return outline;
}

Outline spiral(Dice& dice) {
  const int turns = dice.between(1, 4), corners = dice.between(4, 9);
  Outline outline;
  const int n = turns * corners;
  const auto radius = [&](int i, double width) { return 20 + 60.0 * i / corners + width; };
  for (int i = 0; i <= n; ++i) outline.push_back(at_angle(2 * std::numbers::pi * i / corners, radius(i, 30)));
  for (int i = n; i >= 0; --i) outline.push_back(at_angle(2 * std::numbers::pi * i / corners, radius(i, 0)));
  return outline;
}

// An outside of 8 or more corners about a hole, which a doubled edge joins to it.
Outline hole(Dice& dice) {
  Outline inside = around(dice, 10, 40), outside;
  const int n = dice.between(8, 16);
  for (int i = 0; i < n; ++i) outside.push_back(at_angle(2 * std::numbers::pi * i / n, dice.uniform(60, 200)));
  if (!is_simple(inside) || !is_simple(outside)) return {};
  const std::size_t from = dice.below(static_cast<std::uint32_t>(outside.size()));
  for (std::size_t to = 0; to < inside.size(); ++to) {
    bool free = true;
    for (std::size_t i = 0; i < inside.size() && free; ++i) {
      const GridPoint &a = inside[i], &b = after(inside, i);
      free = !cross_inside(outside[from], inside[to], a, b) && (i == to || !on_segment(a, outside[from], inside[to]));
    }
    for (std::size_t i = 0; i < outside.size() && free; ++i) {
      free = !cross_inside(outside[from], inside[to], outside[i], after(outside, i)) &&
             (i == from || !on_segment(outside[i], outside[from], inside[to]));
    }
    if (!free || twice_area(inside) <= 0) continue;
    Outline joined(outside.begin(), outside.begin() + static_cast<std::ptrdiff_t>(from) + 1);
    for (std::size_t i = 0; i <= inside.size(); ++i) {
      joined.push_back(inside[(to + inside.size() - i) % inside.size()]);
    }
    joined.insert(joined.end(), outside.begin() + static_cast<std::ptrdiff_t>(from), outside.end());
    return joined;
  }
  return {};
}

// Two outlines, side by side, with a corner in common.
Outline pinched(Dice& dice) {
  Outline left = around(dice, 20, 90), right = around(dice, 20, 90);
  if (!is_simple(left) || !is_simple(right) || twice_area(left) <= 0 || twice_area(right) <= 0) return {};
  const auto by_x = [](const GridPoint& a, const GridPoint& b) { return a.x < b.x; };
  std::rotate(left.begin(), std::max_element(left.begin(), left.end(), by_x), left.end());
  std::rotate(right.begin(), std::min_element(right.begin(), right.end(), by_x), right.end());
  const std::int64_t x = left[0].x - right[0].x, y = left[0].y - right[0].y;
  for (const GridPoint& p : left) {
    if (p.x == left[0].x && !(p == left[0])) return {};
  }
  for (const GridPoint& p : right) left.push_back({p.x + x, p.y + y});
  return left;
}

Outline attempt(OutlineKind kind, Dice& dice) {
  switch (kind) {
    case OutlineKind::convex:
      return hull(around(dice, 300, 900));
    case OutlineKind::star:
      return around(dice, 5, 900);
    case OutlineKind::tangled:
      return tangled(dice);
    case OutlineKind::comb:
      return comb(dice);
    case OutlineKind::spiral:
      return spiral(dice);
    case OutlineKind::hole:
      return hole(dice);
    case OutlineKind::pinched:
      break;
  }
  return pinched(dice);
}

}  // namespace

std::int64_t twice_area(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

std::int64_t twice_area(const Outline& outline) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    sum += outline[i].x * after(outline, i).y - outline[i].y * after(outline, i).x;
  }
  return sum;
}

bool on_segment(const GridPoint& p, const GridPoint& a, const GridPoint& b) {
  return twice_area(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}

bool cross_inside(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
  const auto sign = [](std::int64_t v) { return (v > 0) - (v < 0); };
  return sign(twice_area(a, b, c)) * sign(twice_area(a, b, d)) < 0 &&
         sign(twice_area(c, d, a)) * sign(twice_area(c, d, b)) < 0;
}

Outline random_outline(OutlineKind kind, Dice& dice) {
  for (;;) {
    const Outline outline = attempt(kind, dice);
    const bool joined = kind == OutlineKind::hole || kind == OutlineKind::pinched;
    if (joined ? !outline.empty() : is_simple(outline)) return outline;
  }
}

void add_collinear_corners(Outline& outline, Dice& dice) {
  Outline more;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const GridPoint &a = outline[i], &b = after(outline, i);
    more.push_back(a);
    const std::int64_t parts = std::int64_t{1} + dice.below(4);  // all divide kStep
    for (std::int64_t k = 1; k < parts; ++k) {
      if (dice.chance(0.7)) more.push_back({a.x + (b.x - a.x) / parts * k, a.y + (b.y - a.y) / parts * k});
    }
  }
  outline = more;
}

void add_repeated_corners(Outline& outline, Dice& dice) {
  Outline more;
  for (const GridPoint& p : outline) {
    for (int times = dice.chance(0.3) ? dice.between(2, 3) : 1; times-- > 0;) more.push_back(p);
  }
  outline = more;
}

void add_spikes(Outline& outline, Dice& dice) {
  for (int wanted = dice.between(1, 3); wanted-- > 0;) {
    const std::size_t at = dice.below(static_cast<std::uint32_t>(outline.size()));
    const GridPoint foot = outline[at];
    GridPoint tip = {foot.x + kStep * dice.between(-60, 60), foot.y + kStep * dice.between(-60, 60)};
    if (dice.chance(0.3)) tip = {2 * foot.x - after(outline, at).x, 2 * foot.y - after(outline, at).y};
    bool free = !(tip == foot);
    for (std::size_t i = 0; i < outline.size() && free; ++i) {
      const GridPoint &a = outline[i], &b = after(outline, i);
      free = !cross_inside(foot, tip, a, b) && !on_segment(tip, a, b) && (a == foot || !on_segment(a, foot, tip)) &&
             (a == foot || b == foot || !on_segment(foot, a, b));
    }
    // If the outline visits its foot more than once, the spike may cross it.
    free = free && std::count(outline.begin(), outline.end(), foot) == 1;
    if (free) outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(at) + 1, {tip, foot});
  }
}

void turn_around(Outline& outline, Dice& dice) {
  std::rotate(outline.begin(), outline.begin() + dice.below(static_cast<std::uint32_t>(outline.size())), outline.end());
  if (dice.chance(0.5)) std::reverse(outline.begin(), outline.end());
}

Placing random_placing(Dice& dice) {
  Placing placing;
  if (dice.chance(0.7)) {  // tilted, sheared, stretched
    const auto whole = [&] { return Vec3(dice.between(-9, 9), dice.between(-9, 9), dice.between(-9, 9)); };
    do {
      placing.right = whole();
      placing.up = whole();
    } while (placing.right.y() * placing.up.x() == placing.right.x() * placing.up.y());
  }
  if (dice.chance(0.3)) placing.origin = 0x1p31 * dice.lattice(9);  // far from the origin: 2^-20 of it wide
  const double size = dice.chance(0.3) ? std::ldexp(1, dice.between(-1060, 900)) : 1;
  placing.origin *= size;
  placing.right *= size;
  placing.up *= size;
  return placing;
}

}  // namespace meshgauge::api::test
