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
// Proof. Each axis of the mesh's box is cut into 64 cells. The number of a coordinate's cell is a composition of
// monotone roundings: if one coordinate has a smaller cell than another one, it is smaller. A box is widened by `reach`
// and rounded outwards before its cells are marked, so a triangle whose box touches no marked cell is, on some axis,
// beyond the widened box. (A first test is quicker and passes all of these: a triangle that spans few cells around
// those of a corner touches no marked cell if none is within kRing cells of the corner.) The last test compares
// distances of boxes: a gap of two coordinates errs by u relatively, the sum of three squares by less than 8u and
// 2^-1000, for which kNearer and kLeast have room.
class Vicinity {
 public:
  // `box`: that of the mesh, in the frame.
  explicit Vicinity(const Box& box);

  // Adds the points within `reach` of `box`, in frame units.
  void add(const Box& box, double reach);

  // Returns the numbers of the triangles, ascending. nullopt: interrupted. Linear time.
  std::optional<std::vector<std::uint32_t>> triangles(MeshView mesh, const Frame& frame,
                                                      const Interrupted& interrupted) const;

 private:
  static constexpr std::uint32_t kCells = 64;                       // on each axis: the bits of a row
  static constexpr std::uint32_t kRing = 2;                         // cells
  static constexpr std::size_t kFewBoxes = 16;                      // so many are worth the last test
  static constexpr std::size_t kManyRows = 64;                      // a triangle over more rows counts as near
  static constexpr std::size_t kMostMarked = std::size_t{1} << 18;  // rows; beyond, every triangle counts as near
  static constexpr double kNearer = 1 + 0x1p-48;
  static constexpr double kLeast = 0x1p-1000;

  using Rows = std::array<std::uint64_t, std::size_t{kCells} * kCells>;  // bit x of row 64 z + y
  using Cell = std::array<std::uint32_t, 3>;
  struct Near {
    Box box;
    double reach_sq;
  };

  Cell cell(const Vec3& p) const;
  // The cell, a byte for each axis, and kClose if it is within kRing cells of a marked one.
  std::uint32_t packed(const Vec3& p) const;
  bool marked(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  bool within(const Box& box) const;

  Vec3 low_;
  Vec3 scale_;
  Rows rows_{};   // the marked cells
  Rows close_{};  // the cells within kRing of them
  std::size_t rows_marked_ = 0;
  std::vector<Near> boxes_;
  std::size_t count_ = 0;
};

}  // namespace meshgauge
