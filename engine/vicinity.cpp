#include "engine/vicinity.h"

#include <algorithm>
#include <utility>

#include "engine/large_array.h"
#include "engine/mesh_index.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr double kSmallestBox = 0x1p-900;  // a thinner box is not divided into cells
constexpr std::uint32_t kClose = 0x8000'0000U;

std::uint64_t bits(std::uint32_t first, std::uint32_t last) {
  return (~std::uint64_t{0} >> (63 - last + first)) << first;
}

std::size_t row(std::uint32_t y, std::uint32_t z) { return 64 * std::size_t{z} + y; }

// Whether each coordinate of cell `b` is from 2 below to 1 above that of `a`. Both are packed, in 6 bits of each byte.
bool neighbours(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t differences = ((a & 0x3F3F3FU) | 0x808080U) - (b & 0x3F3F3FU);
  return ((differences + 0x010101U) & 0xFCFCFCU) == 0x808080U;
}

Box box_of(MeshView mesh, std::uint32_t t, const Frame& frame) {
  Box box;
  for (int i = 0; i < 3; ++i) box.extend(frame.to_frame(mesh.corner(t, i)));
  return box;
}

}  // namespace

Vicinity::Vicinity(const Box& box) : low_(box.low) {
  for (int k = 0; k < 3; ++k) {
    const double width = box.high[k] - box.low[k];
    scale_[k] = width > kSmallestBox ? kCells / width : 0;
  }
}

// A vertex that no triangle uses may have any coordinates, NaN included: its cell is never used.
Vicinity::Cell Vicinity::cell(const Vec3& p) const {
  Cell cell{};
  for (int k = 0; k < 3; ++k) {
    const double at = (p[k] - low_[k]) * scale_[k];
    cell[static_cast<std::size_t>(k)] = at > 0 ? static_cast<std::uint32_t>(std::min(at, kCells - 1.0)) : 0;
  }
  return cell;
}

std::uint32_t Vicinity::packed(const Vec3& p) const {
  const auto [x, y, z] = cell(p);
  return x | y << 8 | z << 16 | ((close_[row(y, z)] >> x & 1) != 0 ? kClose : 0);
}

void Vicinity::add(const Box& box, double reach) {
  Box wide;
  for (int k = 0; k < 3; ++k) {
    wide.low[k] = -rounding::add_up(-box.low[k], reach);
    wide.high[k] = rounding::add_up(box.high[k], reach);
  }
  if (++count_ <= kFewBoxes) boxes_.push_back({box, reach * reach});
  const auto mark = [&](Rows& rows, std::uint32_t ring) {
    Cell low = cell(wide.low), high = cell(wide.high);
    for (std::uint32_t& at : low) at -= std::min(at, ring);
    for (std::uint32_t& at : high) at = std::min(at + ring, kCells - 1);
    rows_marked_ += std::size_t{1} * (high[2] - low[2] + 1) * (high[1] - low[1] + 1);
    if (rows_marked_ > kMostMarked) return;
    for (std::uint32_t z = low[2]; z <= high[2]; ++z) {
      for (std::uint32_t y = low[1]; y <= high[1]; ++y) rows[row(y, z)] |= bits(low[0], high[0]);
    }
  };
  mark(rows_, 0);
  mark(close_, kRing);
}

// Whether a cell in the box of three packed cells is marked.
bool Vicinity::marked(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const auto range = [&](unsigned shift) {
    const auto [low, high] = std::minmax({a >> shift & 63U, b >> shift & 63U, c >> shift & 63U});
    return std::pair(low, high);
  };
  const auto [x0, x1] = range(0);
  const auto [y0, y1] = range(8);
  const auto [z0, z1] = range(16);
  if (std::size_t{1} * (z1 - z0 + 1) * (y1 - y0 + 1) > kManyRows) return true;
  const std::uint64_t all = bits(x0, x1);
  for (std::uint32_t z = z0; z <= z1; ++z) {
    for (std::uint32_t y = y0; y <= y1; ++y) {
      if (rows_[row(y, z)] & all) return true;
    }
  }
  return false;
}

bool Vicinity::within(const Box& box) const {
  return std::any_of(boxes_.begin(), boxes_.end(), [&](const Near& near) {
    const Vec3 gap = (near.box.low - box.high).cwiseMax(box.low - near.box.high).cwiseMax(0);
    return gap.squaredNorm() <= near.reach_sq * kNearer + kLeast;
  });
}

std::optional<std::vector<std::uint32_t>> Vicinity::triangles(MeshView mesh, const Frame& frame,
                                                              const Interrupted& interrupted) const {
  std::vector<std::uint32_t> found;
  LargeArray<std::uint32_t> cells(mesh.positions.size());
  const bool all = rows_marked_ > kMostMarked;
  bool done = each_unless(interrupted, cells.size(),
                          [&](std::uint32_t v) { cells[v] = packed(frame.to_frame(mesh.positions[v])); });
  done = done && each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
           const std::uint32_t a = cells[mesh.triangles[t][0]], b = cells[mesh.triangles[t][1]],
                               c = cells[mesh.triangles[t][2]];
           if (!all && !(a & kClose) && neighbours(a, b) && neighbours(a, c)) return;
           if (!all && !marked(a, b, c)) return;
           if (count_ <= kFewBoxes && !within(box_of(mesh, t, frame))) return;
           found.push_back(t);
         });
  if (!done) return std::nullopt;
  return found;
}

}  // namespace meshgauge
