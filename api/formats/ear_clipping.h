// A face's outline as triangles, by clipping one ear after another. Decisions are exact (orientation.h).
//
// A corner is clipped by the triangle (corner before, corner, corner after); what remains is an outline of one
// corner less. Corners on a line with their neighbours (straight ones, repeated ones, tips of spikes) come first: their
// triangle spans nothing but the two edges. Then come ears: corners that turn left, into whose triangle no other part
// of the outline leads. An outline that merely touches itself (a hole that a doubled edge joins to the outside) stays
// so.
//
// Surface. Let w(x) be how often the outline winds around x. Each clipping subtracts the triangle, by its sign, from
// the outline as a chain, so w is the sum of the triangles' indicators, by their signs, almost everywhere. When no
// triangle turns right, the triangles therefore cover exactly the points with w > 0, and where w is 0 or 1 they do not
// overlap. Triangles without area span a part of the outline. So the surface of an outline that does not cross itself
// is what it encloses and itself.
//
// An outline that crosses itself may leave no ear. What is left is then turned around if it winds around a negative
// area; else the corner is clipped whose triangle is least at fault: the smallest depth to which the outline leads into
// it or, for one that turns right, its height. A crossing by a rounding error thus moves the surface by about
// as much.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "api/formats/outline.h"

namespace meshgauge::api {

class EarClipper {
 public:
  using Clipped = std::array<std::uint32_t, 3>;  // indices into the outline, in its order

  explicit EarClipper(StepBudget& budget) : budget_(budget) {}

  // Splits an outline of at least three corners, of either orientation, into as many triangles less two, valid until
  // the next call. Precondition: finite coordinates of at most 2^500. Empty: the budget is spent.
  //
  // `crosses`: whether the outline crosses itself (outline.h). Then an edge may lead through an ear without a corner in
  // it, and all edges are asked, which takes n^2 steps.
  std::span<const Clipped> clip(std::span<const Point2> outline, bool crosses);

  // Whether the last outline had no ear left at some step: it crosses itself, or does so by its rounding.
  bool gave_way() const { return gave_way_; }

 private:
  struct Corner {
    std::uint32_t previous = 0;
    std::uint32_t next = 0;
    int turn = 0;          // 1: left, -1: right, 0: on a line with its neighbours
    bool blocked = false;  // found to be no ear since its neighbours last changed
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
  std::vector<std::uint32_t> straight_;  // to be clipped first; may have been already
  std::vector<Clipped> out_;
  std::uint32_t cursor_ = 0;
  std::size_t left_ = 0;         // corners not clipped
  std::size_t right_turns_ = 0;  // of them
  std::size_t misses_ = 0;       // corners in a row that are no ears
  bool stale_ = false;           // something was clipped after a corner was found blocked
  bool gave_way_ = false;
  bool spent_ = false;

  // The corners by cells of a grid over their box.
  Point2 low_;
  double cells_per_x_ = 0;
  double cells_per_y_ = 0;
  std::size_t side_cells_ = 1;
  std::vector<std::uint32_t> cell_begin_;
  std::vector<std::uint32_t> cell_corners_;
};

}  // namespace meshgauge::api
