#include "engine/vicinity.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/large_array.h"
#include "engine/mesh_index.h"

namespace meshgauge {
namespace {

constexpr double kSmallestBox = 0x1p-900;  // a thinner box is not divided into cells
constexpr std::uint32_t kClose = 0x8000'0000U;

std::uint64_t bits(std::uint32_t first, std::uint32_t last) {
  return (~std::uint64_t{0} >> (63 - last + first)) << first;
}

// So many that a cell of a surface has some ten triangles.
std::uint32_t cells_for(std::size_t triangles) {
  return triangles < 1024 ? 8 : triangles < 4096 ? 16 : triangles < 32768 ? 32 : 64;
}

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

Vicinity::Vicinity(const Box& box, std::size_t triangles)
    : low_(box.low),
      cells_(cells_for(triangles)),
      rows_(std::size_t{cells_} * cells_),
      close_(rows_.size()),
      first_{cells_, cells_, cells_} {
  for (int k = 0; k < 3; ++k) {
    const double width = box.high[k] - box.low[k];
    scale_[k] = width > kSmallestBox ? cells_ / width : 0;
  }
}

// A vertex that no triangle uses may have any coordinates, NaN included: its cell is never used.
std::uint32_t Vicinity::cell(double x, int axis) const {
  const double at = (x - low_[axis]) * scale_[axis];
  return at > 0 ? static_cast<std::uint32_t>(std::min(at, cells_ - 1.0)) : 0;
}

std::uint32_t Vicinity::packed(const Vec3& p) const {
  const std::uint32_t x = cell(p[0], 0), y = cell(p[1], 1), z = cell(p[2], 2);
  return x | y << 8 | z << 16 | ((close_[row(y, z)] >> x & 1) != 0 ? kClose : 0);
}

// A distance on one axis, from below, of the coordinates in a cell from the box.
double Vicinity::gap(int axis, std::uint32_t cell, const Box& box) const {
  if (scale_[axis] == 0) return 0;
  const double low = low_[axis] + cell / scale_[axis], high = low_[axis] + (cell + 1) / scale_[axis];
  return std::max({0.0, box.low[axis] - high - kPad, low - box.high[axis] - kPad});
}

void Vicinity::add(const Box& box, double reach) {
  const bool few = ++count_ <= kFewBoxes;
  if (few) boxes_.push_back({box, reach * reach});
  const double wide = reach + kPad;
  const auto range = [&](int axis, double on_axis) {
    return std::pair(cell(box.low[axis] - on_axis, axis), cell(box.high[axis] + on_axis, axis));
  };
  const auto [x0, x1] = range(0, wide);
  const auto [y0, y1] = range(1, wide);
  const auto [z0, z1] = range(2, wide);
  rows_marked_ += std::size_t{1} * (z1 - z0 + 1) * (y1 - y0 + 1);
  if (rows_marked_ > kMostMarked) return;
  first_ = {0, std::min(first_[1], y0), std::min(first_[2], z0)};
  last_ = {0, std::max(last_[1], y1), std::max(last_[2], z1)};
  std::array<double, kMostCells> gap_y;
  for (std::uint32_t y = y0; y <= y1; ++y) gap_y[y] = gap(1, y, box);
  for (std::uint32_t z = z0; z <= z1; ++z) {
    const double gap_z = gap(2, z, box);
    for (std::uint32_t y = y0; y <= y1; ++y) {
      const double left_sq = wide * wide - gap_z * gap_z - gap_y[y] * gap_y[y];
      if (left_sq < 0) continue;
      const auto [first, last] = few ? range(0, std::sqrt(left_sq) + kPad) : std::pair(x0, x1);
      rows_[row(y, z)] |= bits(first, last);
    }
  }
}

// Widens the marked cells by kRing on each axis, one axis after the other.
void Vicinity::find_close() {
  const auto around = [&](std::uint32_t at, std::uint32_t axis, auto&& visit) {
    const std::uint32_t first = std::max(first_[axis], at - std::min(at, kRing));
    for (std::uint32_t near = first; near <= std::min(last_[axis], at + kRing); ++near) visit(near);
  };
  const auto low = [&](std::uint32_t axis) { return first_[axis] - std::min(first_[axis], kRing); };
  const auto high = [&](std::uint32_t axis) { return std::min(last_[axis] + kRing, cells_ - 1); };
  Rows wide(rows_.size());
  for (std::uint32_t z = first_[2]; z <= last_[2]; ++z) {
    for (std::uint32_t y = low(1); y <= high(1); ++y) {
      std::uint64_t all = 0;
      around(y, 1, [&](std::uint32_t near) { all |= rows_[row(near, z)]; });
      wide[row(y, z)] = all | all << 1 | all << 2 | all >> 1 | all >> 2;
    }
  }
  for (std::uint32_t z = low(2); z <= high(2); ++z) {
    for (std::uint32_t y = low(1); y <= high(1); ++y) {
      around(z, 2, [&](std::uint32_t near) { close_[row(y, z)] |= wide[row(y, near)]; });
    }
  }
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
                                                              const Interrupted& interrupted) {
  std::vector<std::uint32_t> found;
  if (count_ > 0 && rows_marked_ <= kMostMarked) find_close();
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
