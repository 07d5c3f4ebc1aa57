// The part of a mesh near some boxes, found in one pass over the mesh, without an order or a tree.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/frame.h"
#include "engine/mesh/large_array.h"

namespace meshgauge {

// The cells that a mesh's vertices lie in.
struct MeshCells {
  static constexpr std::uint32_t kMost = 64;  // on each axis: the bits of a row

  struct Grid {
    Vec3 low;
    Vec3 scale;
    std::uint32_t cells;  // on each axis

    // A vertex that no triangle uses may have any coordinates, NaN included: its cell is never used.
    std::uint32_t cell(double x, int axis) const {
      return static_cast<std::uint32_t>(std::min(std::max(0.0, (x - low[axis]) * scale[axis]), cells - 1.0));
    }
  };

  MeshView mesh;
  Frame frame;
  Grid grid;
  LargeArray<std::uint32_t> packed;  // by vertex: its cell, a byte for each axis
  // By triangle: the place of its first corner's cell in the rows along x, each with room for kMost cells; for a
  // triangle that spans many cells, the place after the last row.
  LargeArray<std::uint32_t> places;

  // `box`: that of the mesh, in the frame. Linear time. If it is interrupted, complete() is false.
  MeshCells(MeshView of, const Box& box, const Frame& in, const Interrupted& interrupted);
  bool complete() const { return !places.empty(); }
};

// Statement. triangles() returns all triangles that are within `reach` of one of the boxes, and some others.
//
// Proof. Each axis of the mesh's box is cut into cells. The number of a coordinate's cell is a composition of
// monotone roundings: if one coordinate has a smaller cell than another one, it is smaller. So the cells of a
// triangle's box hold the triangle, and it is within reach only if one of them is. The ends of a cell, computed
// backwards, err by less than 16u = 2^-49, since coordinates are at most 1 and widths at most 2; kPad covers that. Of
// each row of cells along x, add() marks those up to the largest distance on x that the gaps on y and z, each less by
// kPad, leave of the reach: the root of three terms that err by some u of at most 12, which kPad covers, too, since it
// is added to the reach before it is squared. A marked cell outside of the widened boxes' range on an axis is not
// within reach. (A first test is quicker: a triangle that spans few cells around that of its first corner touches no
// marked cell if none is within kRing cells of the corner.) The last test compares distances of boxes: a gap of two
// coordinates errs by u relatively, the sum of three squares by less than 8u and 2^-1000, for which kNearer and kLeast
// have room.
class Vicinity {
 public:
  explicit Vicinity(const MeshCells& cells);  // borrows them

  // Adds the points within `reach` of `box`, in frame units.
  void add(const Box& box, double reach);

  // Returns the numbers of the triangles, ascending. nullopt: interrupted. Linear time.
  std::optional<std::vector<std::uint32_t>> triangles(const Interrupted& interrupted);

 private:
  static constexpr std::uint32_t kRing = 2;                         // cells
  static constexpr std::size_t kFewBoxes = 16;                      // so many are worth the last test
  static constexpr std::size_t kFewerBoxes = 4;                     // for these it takes less than marked()
  static constexpr std::size_t kManyRows = 64;                      // a triangle over more rows counts as near
  static constexpr std::size_t kMostMarked = std::size_t{1} << 18;  // rows; beyond, every triangle counts as near
  static constexpr double kPad = 0x1p-40;
  static constexpr double kNearer = 1 + 0x1p-48;
  static constexpr double kLeast = 0x1p-1000;

  using Rows = std::vector<std::uint64_t>;  // by row of cells along x: bit x
  using Cell = std::array<std::uint32_t, 3>;
  struct Near {
    Box box;
    double reach_sq;
  };

  std::size_t row(std::uint32_t y, std::uint32_t z) const { return std::size_t{cells_.grid.cells} * z + y; }
  double gap(int axis, std::uint32_t cell, const Box& box) const;
  void find_close();
  bool marked(const Triangle& triangle) const;
  bool within(const Box& box) const;

  const MeshCells& cells_;
  Rows rows_;    // the marked cells
  Rows close_;   // the cells within kRing of them, and a row for triangles that span many cells
  Cell first_;   // of the widened boxes: the smallest coordinates of a cell
  Cell last_{};  // the largest ones
  std::size_t rows_marked_ = 0;
  std::vector<Near> boxes_;
  std::size_t count_ = 0;
};

}  // namespace meshgauge
