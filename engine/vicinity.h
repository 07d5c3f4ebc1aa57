// The part of a mesh near some boxes, found in one pass over the mesh, without an order or a tree.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/control.h"
#include "engine/frame.h"
#include "engine/mesh.h"

namespace meshgauge {

// Statement. triangles() returns all triangles that are within `reach` of one of the boxes, and some others.
//
// Proof. Each axis of the mesh's box is cut into cells. The number of a coordinate's cell is a composition of
// monotone roundings: if one coordinate has a smaller cell than another one, it is smaller. So the cells of a
// triangle's box hold the triangle, and it is within reach only if one of them is. The ends of a cell, computed
// backwards, err by less than 16u = 2^-49, since coordinates are at most 1 and widths at most 2; kPad covers that. Of
// each row of cells along x, add() marks those up to the largest distance on x that the gaps on y and z, each less by
// kPad, leave of the reach: the root of three terms that err by some u of at most 12, which kPad covers, too, since it
// is added to the reach before it is squared. (A first test is quicker: a triangle that spans few cells around those of
// a corner touches no marked cell if none is within kRing cells of the corner.) The last test compares distances of
// boxes: a gap of two coordinates errs by u relatively, the sum of three squares by less than 8u and 2^-1000, for which
// kNearer and kLeast have room.
class Vicinity {
 public:
  // `box`: that of the mesh, in the frame. `triangles`: how many it has.
  Vicinity(const Box& box, std::size_t triangles);

  // Adds the points within `reach` of `box`, in frame units.
  void add(const Box& box, double reach);

  // Returns the numbers of the triangles, ascending. nullopt: interrupted. Linear time.
  std::optional<std::vector<std::uint32_t>> triangles(MeshView mesh, const Frame& frame,
                                                      const Interrupted& interrupted);

 private:
  static constexpr std::uint32_t kMostCells = 64;                   // on each axis: the bits of a row
  static constexpr std::uint32_t kRing = 2;                         // cells
  static constexpr std::size_t kFewBoxes = 16;                      // so many are worth the last test
  static constexpr std::size_t kManyRows = 64;                      // a triangle over more rows counts as near
  static constexpr std::size_t kMostMarked = std::size_t{1} << 18;  // rows; beyond, every triangle counts as near
  static constexpr double kPad = 0x1p-40;
  static constexpr double kNearer = 1 + 0x1p-48;
  static constexpr double kLeast = 0x1p-1000;

  using Rows = std::vector<std::uint64_t>;  // bit x of row cells_ * z + y
  using Cell = std::array<std::uint32_t, 3>;
  struct Near {
    Box box;
    double reach_sq;
  };

  std::size_t row(std::uint32_t y, std::uint32_t z) const { return std::size_t{cells_} * z + y; }
  std::uint32_t cell(double x, int axis) const;
  // The cell, a byte for each axis, and kClose if it is within kRing cells of a marked one.
  std::uint32_t packed(const Vec3& p) const;
  double gap(int axis, std::uint32_t cell, const Box& box) const;
  void find_close();
  bool marked(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  bool within(const Box& box) const;

  Vec3 low_;
  Vec3 scale_;
  std::uint32_t cells_;  // on each axis
  Rows rows_;            // the marked cells
  Rows close_;           // the cells within kRing of them
  Cell first_;           // of the marked rows: the smallest y and z
  Cell last_{};          // the largest ones
  std::size_t rows_marked_ = 0;
  std::vector<Near> boxes_;
  std::size_t count_ = 0;
};

}  // namespace meshgauge
