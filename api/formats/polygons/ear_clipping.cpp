#include "api/formats/polygons/ear_clipping.h"

#include <algorithm>
#include <limits>

namespace meshgauge::api {
namespace {

// Not std::hypot, whose last digit differs from library to library. Coordinates are at most 2^500; 0 below 2^-538.
double length(const Point2& a, const Point2& b) {
  const double x = b.x - a.x, y = b.y - a.y;
  return std::sqrt(x * x + y * y);
}

// Returns the distance of p from the line through a and b, or from a if a = b. Not exact: only for choosing corners.
double height(const Point2& a, const Point2& b, const Point2& p) {
  const double base = length(a, b);
  if (base == 0) return length(a, p);
  return std::abs((b.x - a.x) / base * (p.y - a.y) - (b.y - a.y) / base * (p.x - a.x));
}

}  // namespace

std::span<const EarClipper::Clipped> EarClipper::clip(std::span<const Point2> outline, bool crosses) {
  start(outline, crosses);
  while (left_ > 3 && !spent_) {
    if (clip_straight()) continue;
    if (misses_ >= left_) {
      if (stale_) {
        rescan();
      } else {
        give_way();
      }
      continue;
    }
    const std::uint32_t corner = cursor_;
    if (is_ear(corner)) {
      clip_corner(corner);
      // Skips the next corner: clipping in turns around the outline gives small triangles and short searches.
      cursor_ = corners_[corners_[corner].next].next;
    } else {
      ++misses_;
      cursor_ = corners_[corner].next;
    }
  }
  if (spent_) return {};
  const Corner& last = corners_[cursor_];
  out_.push_back({last.previous, cursor_, last.next});
  gave_way_ = gave_way_ || last.turn < 0;
  return out_;
}

void EarClipper::start(std::span<const Point2> outline, bool crosses) {
  points_ = outline;
  crosses_ = crosses;
  side_ = area_sign(outline) < 0 ? -1 : 1;
  const auto n = static_cast<std::uint32_t>(outline.size());
  corners_.assign(n, {});
  straight_.clear();
  out_.clear();
  left_ = n;
  cursor_ = 1;
  right_turns_ = misses_ = 0;
  stale_ = gave_way_ = false;
  spent_ = !budget_.spend(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    corners_[i].previous = i == 0 ? n - 1 : i - 1;
    corners_[i].next = i + 1 == n ? 0 : i + 1;
  }
  for (std::uint32_t i = n; i-- > 0;) update(i);
  sort_into_cells();
}

void EarClipper::sort_into_cells() {
  Point2 high = low_ = points_[0];
  for (const Point2& p : points_) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  side_cells_ = static_cast<std::size_t>(std::sqrt(static_cast<double>(points_.size()) / 4)) + 1;
  const auto cells = static_cast<double>(side_cells_);
  cells_per_x_ = high.x > low_.x ? cells / (high.x - low_.x) : 0;
  cells_per_y_ = high.y > low_.y ? cells / (high.y - low_.y) : 0;
  const auto cell = [&](const Point2& p) { return row(p.y) * side_cells_ + column(p.x); };
  cell_begin_.assign(side_cells_ * side_cells_ + 1, 0);
  for (const Point2& p : points_) ++cell_begin_[cell(p) + 1];
  for (std::size_t i = 1; i < cell_begin_.size(); ++i) cell_begin_[i] += cell_begin_[i - 1];
  cell_corners_.resize(points_.size());
  for (std::size_t i = points_.size(); i-- > 0;) {
    // cell_begin_[c + 1] is the end of cell c here. Filling backwards turns it into the begin of cell c.
    const std::size_t at = cell(points_[i]);
    cell_corners_[--cell_begin_[at + 1]] = static_cast<std::uint32_t>(i);
  }
  std::rotate(cell_begin_.begin(), cell_begin_.begin() + 1, cell_begin_.end());
  cell_begin_.back() = static_cast<std::uint32_t>(points_.size());
}

// column() and row() round monotonically, so the cells of a box contain all corners in it. An infinite number of cells
// per unit gives 0 or infinity.
std::size_t EarClipper::column(double x) const {
  const double at = (x - low_.x) * cells_per_x_;
  return at < static_cast<double>(side_cells_) ? static_cast<std::size_t>(std::max(at, 0.0)) : side_cells_ - 1;
}

std::size_t EarClipper::row(double y) const {
  const double at = (y - low_.y) * cells_per_y_;
  return at < static_cast<double>(side_cells_) ? static_cast<std::size_t>(std::max(at, 0.0)) : side_cells_ - 1;
}

void EarClipper::update(std::uint32_t corner) {
  Corner& c = corners_[corner];
  right_turns_ -= c.turn < 0;
  c.turn = turn(c.previous, corner, c.next);
  right_turns_ += c.turn < 0;
  c.blocked = false;
  if (c.turn == 0) straight_.push_back(corner);
}

void EarClipper::clip_corner(std::uint32_t corner) {
  Corner& c = corners_[corner];
  out_.push_back({c.previous, corner, c.next});
  right_turns_ -= c.turn < 0;
  c.clipped = true;
  corners_[c.previous].next = c.next;
  corners_[c.next].previous = c.previous;
  if (cursor_ == corner) cursor_ = c.next;
  --left_;
  misses_ = 0;
  stale_ = true;
  update(c.previous);
  update(c.next);
}

bool EarClipper::clip_straight() {
  if (straight_.empty()) return false;
  const std::uint32_t corner = straight_.back();
  straight_.pop_back();
  if (!corners_[corner].clipped && corners_[corner].turn == 0) clip_corner(corner);
  return true;
}

bool EarClipper::is_ear(std::uint32_t corner) {
  Corner& c = corners_[corner];
  if (c.turn < 0 || c.blocked) return false;
  if (right_turns_ == 0 && !crosses_) return true;
  const Clipped triangle = {c.previous, corner, c.next};
  each_inside(corner, [&](std::uint32_t inside) {
    c.blocked = leads_into(inside, triangle);
    return !c.blocked;
  });
  if (crosses_ && !c.blocked) {
    each_through(corner, [&](std::uint32_t) {
      c.blocked = true;
      return false;
    });
  }
  return !c.blocked && !spent_;
}

// Passes to take() the corners that turn right and lie in the triangle of `corner` or on its border, until it returns
// false. If an outline leads into the triangle, the corner farthest inside turns right.
template <class Take>
void EarClipper::each_inside(std::uint32_t corner, Take take) {
  const Corner& c = corners_[corner];
  const Point2 &a = points_[c.previous], &b = points_[corner], &d = points_[c.next];
  const auto [low_x, high_x] = std::minmax({a.x, b.x, d.x});
  const auto [low_y, high_y] = std::minmax({a.y, b.y, d.y});
  const std::size_t first = column(low_x), last = column(high_x);
  for (std::size_t y = row(low_y); y <= row(high_y); ++y) {
    const std::uint32_t begin = cell_begin_[y * side_cells_ + first], end = cell_begin_[y * side_cells_ + last + 1];
    if (!budget_.spend(1 + end - begin)) {
      spent_ = true;
      return;
    }
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t other = cell_corners_[k];
      const Point2& p = points_[other];
      if (corners_[other].turn >= 0 || corners_[other].clipped) continue;
      if (p.x < low_x || p.x > high_x || p.y < low_y || p.y > high_y) continue;
      if (other == c.previous || other == c.next || other == corner) continue;
      spent_ = !budget_.spend(kOrientationSteps);
      if (turn(c.previous, corner, other) < 0 || turn(corner, c.next, other) < 0) continue;
      if (turn(c.next, c.previous, other) < 0) continue;
      if (!take(other)) return;
    }
  }
}

// Passes to take() the corners whose edge to the next corner crosses the third side of the triangle of `corner`, until
// it returns false.
template <class Take>
void EarClipper::each_through(std::uint32_t corner, Take take) {
  spent_ = spent_ || !budget_.spend(left_ * kOrientationSteps);
  if (spent_) return;
  const std::uint32_t a = corners_[corner].previous, b = corners_[corner].next;
  for (std::uint32_t from = b; from != a; from = corners_[from].next) {
    const std::uint32_t to = corners_[from].next;
    if (turn(a, b, from) * turn(a, b, to) < 0 && turn(from, to, a) * turn(from, to, b) < 0 && !take(from)) return;
  }
}

// Returns true when an edge at the corner `from`, which lies in the triangle, has points inside the triangle next to
// that corner.
bool EarClipper::leads_into(std::uint32_t from, const Clipped& triangle) const {
  const auto leads = [&](std::uint32_t to) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      if (turn(a, b, from) == 0 && turn(a, b, to) <= 0) return false;
    }
    return true;
  };
  return leads(corners_[from].next) || leads(corners_[from].previous);
}

double EarClipper::depth(std::uint32_t inside, const Clipped& triangle) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    least = std::min(least, height(points_[triangle[k]], points_[triangle[(k + 1) % 3]], points_[inside]));
  }
  return least;
}

double EarClipper::fault(std::uint32_t corner) {
  const Corner& c = corners_[corner];
  const Clipped triangle = {c.previous, corner, c.next};
  if (c.turn < 0) {
    return std::min({height(points_[triangle[0]], points_[triangle[1]], points_[triangle[2]]),
                     height(points_[triangle[1]], points_[triangle[2]], points_[triangle[0]]),
                     height(points_[triangle[2]], points_[triangle[0]], points_[triangle[1]])});
  }
  double deepest = 0;
  each_inside(corner, [&](std::uint32_t inside) {
    deepest = std::max(deepest, depth(inside, triangle));
    return true;
  });
  // An edge that leads through the triangle has one of its corners on one side, two on the other.
  each_through(corner, [&](std::uint32_t from) {
    const std::uint32_t to = corners_[from].next;
    const int sides = turn(from, to, triangle[0]) + turn(from, to, triangle[1]) + turn(from, to, triangle[2]);
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t alone : triangle) {
      if (turn(from, to, alone) * sides < 0) least = height(points_[from], points_[to], points_[alone]);
    }
    if (std::isfinite(least)) deepest = std::max(deepest, least);
    return true;
  });
  return deepest;
}

std::uint32_t EarClipper::least_fault() {
  std::uint32_t best = cursor_;
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t corner = cursor_;
  for (std::size_t i = 0; i < left_; ++i, corner = corners_[corner].next) {
    const double its = fault(corner);
    if (its < least) {
      least = its;
      best = corner;
    }
  }
  return best;
}

// Clears all blocked marks: a clipped corner may have blocked a corner other than its neighbours.
void EarClipper::rescan() {
  for (Corner& c : corners_) c.blocked = false;
  spent_ = spent_ || !budget_.spend(corners_.size());
  stale_ = false;
  misses_ = 0;
}

void EarClipper::give_way() {
  gave_way_ = true;
  std::vector<Point2> rest;
  std::uint32_t corner = cursor_;
  for (std::size_t i = 0; i < left_; ++i, corner = corners_[corner].next) rest.push_back(points_[corner]);
  spent_ = spent_ || !budget_.spend(32 * left_);
  if (side_ * area_sign(rest) >= 0) {
    clip_corner(least_fault());
    return;
  }
  side_ = -side_;
  for (std::size_t i = 0; i < left_; ++i, corner = corners_[corner].next) update(corner);
  misses_ = 0;
}

}  // namespace meshgauge::api
