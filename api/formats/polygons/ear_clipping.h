// Splits a face's outline into triangles by ear clipping. Decisions are exact (outline.h).
//
// Clipping a corner cuts off the triangle (corner before, corner, corner after); an outline of one corner less remains.
// Corners on a line with their neighbours (straight ones, repeated ones, tips of spikes) come first: their triangle
// spans only the two edges. Then come ears: corners that turn left, into whose triangle no other part of the outline
// leads. An outline that only touches itself (a hole that a doubled edge joins to the outside) still only touches
// itself after each clipping.
//
// Surface. Let w(x) be how often the outline winds around x. Each clipping subtracts the triangle, by its sign, from
// the outline as a chain, so w is the sum of the triangles' indicators, by their signs, almost everywhere. When no
// triangle turns right, the triangles therefore cover exactly the points with w > 0, and where w is 0 or 1 they do not
// overlap. Triangles without area span a part of the outline. So the surface of an outline that does not cross itself
// is what it encloses and itself.
//
// An outline that crosses itself may leave no ear. If what is left winds around a negative area, it is then reversed.
// Otherwise the corner with the least fault is clipped. The fault of a corner is the depth to which the outline leads
// into its triangle; for a corner that turns right, it is the triangle's height. A crossing by a rounding error thus
// moves the surface by about that error.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "api/formats/polygons/outline.h"

namespace meshgauge::api {

class EarClipper {
 public:
  using Clipped = std::array<std::uint32_t, 3>;  // indices into the outline, in its order

  explicit EarClipper(StepBudget& budget) : budget_(budget) {}

  // Splits an outline of n >= 3 corners, of either orientation, into n - 2 triangles, valid until the next call. Empty:
  // the budget is spent. Precondition: finite coordinates of at most 2^500.
  //
  // `crosses`: whether the outline crosses itself (outline.h). Then an edge may lead through an ear without a corner in
  // it, so that all edges are tested, which takes n^2 steps.
  std::span<const Clipped> clip(std::span<const Point2> outline, bool crosses);

  // Returns true when the last outline had no ear left at some step: it crosses itself, perhaps only by rounding.
  bool gave_way() const { return gave_way_; }

 private:
  struct Corner {
    std::uint32_t previous = 0;
    std::uint32_t next = 0;
    int turn = 0;          // 1: left, -1: right, 0: on a line with its neighbours
    bool blocked = false;  // not an ear when last tested; its neighbours have not changed since
    bool clipped = false;
  };

  void start(std::span<const Point2> outline, bool crosses);
  void sort_into_cells();
  std::size_t column(double x) const;
  std::size_t row(double y) const;
  int turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return side_ * orientation(points_[a], points_[b], points_[c]);
  }
  void update(std::uint32_t corner);
  void clip_corner(std::uint32_t corner);
  bool clip_straight();
  bool is_ear(std::uint32_t corner);
  bool leads_into(std::uint32_t from, const Clipped& triangle) const;
  template <class Take>
  void each_inside(std::uint32_t corner, Take take);
  template <class Take>
  void each_through(std::uint32_t corner, Take take);
  double depth(std::uint32_t inside, const Clipped& triangle) const;
  double fault(std::uint32_t corner);
  std::uint32_t least_fault();
  void rescan();
  void give_way();

  StepBudget& budget_;
  std::span<const Point2> points_;
  bool crosses_ = false;
  int side_ = 1;  // 1: the outline is counter-clockwise
  std::vector<Corner> corners_;
  std::vector<std::uint32_t> straight_;  // to be clipped first; some may be clipped already
  std::vector<Clipped> out_;
  std::uint32_t cursor_ = 0;
  std::size_t left_ = 0;         // corners not clipped
  std::size_t right_turns_ = 0;  // corners not clipped that turn right
  std::size_t misses_ = 0;       // consecutive corners that are not ears
  bool stale_ = false;           // a corner was clipped after another was found blocked
  bool gave_way_ = false;
  bool spent_ = false;

  // A grid over the corners' box, and the corners in each cell.
  Point2 low_;
  double cells_per_x_ = 0;
  double cells_per_y_ = 0;
  std::size_t side_cells_ = 1;
  std::vector<std::uint32_t> cell_begin_;
  std::vector<std::uint32_t> cell_corners_;
};

}  // namespace meshgauge::api
