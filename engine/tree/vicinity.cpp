#include "engine/tree/vicinity.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

constexpr double kSmallestBox = 0x1p-900;  // a thinner box is not divided into cells

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

MeshCells::MeshCells(MeshView of, const Box& box, const Frame& in, const Interrupted& interrupted)
    : mesh(of),
      frame(in),
      grid{box.low, Vec3::Zero(), cells_for(of.triangles.size())},
      packed(of.positions.size()),
      places(of.triangles.size()) {
  for (int k = 0; k < 3; ++k) {
    const double width = box.high[k] - box.low[k];
    if (width > kSmallestBox) grid.scale[k] = grid.cells / width;
  }
  const auto pack = [to = grid, in, positions = of.positions, cells = packed.data()](std::uint32_t v) {
    const Vec3 p = in.to_frame(positions[v]);
    cells[v] = to.cell(p[0], 0) | to.cell(p[1], 1) << 8 | to.cell(p[2], 2) << 16;
  };
  const auto place = [triangles = of.triangles, cells = packed.data(), to = places.data(), rows = grid.cells,
                      spread = kMost * grid.cells * grid.cells](std::uint32_t t) {
    const std::uint32_t a = cells[triangles[t][0]], b = cells[triangles[t][1]], c = cells[triangles[t][2]];
    const std::uint32_t first = kMost * (rows * (a >> 16) + (a >> 8 & 0xFFU)) + (a & 0xFFU);
    to[t] = neighbours(a, b) & neighbours(a, c) ? first : spread;
  };
  const bool done = each_unless(interrupted, packed.size(), pack) && each_unless(interrupted, places.size(), place);
  if (!done) places.clear();
}

Vicinity::Vicinity(const MeshCells& cells)
    : cells_(cells),
      rows_(std::size_t{cells.grid.cells} * cells.grid.cells),
      close_(rows_.size() + 1),
      first_{cells.grid.cells, cells.grid.cells, cells.grid.cells} {}

// A distance on one axis, from below, of the coordinates in a cell from the box.
double Vicinity::gap(int axis, std::uint32_t cell, const Box& box) const {
  const double start = cells_.grid.low[axis], scale = cells_.grid.scale[axis];
  if (scale == 0) return 0;
  const double low = start + cell / scale, high = start + (cell + 1) / scale;
  return std::max({0.0, box.low[axis] - high - kPad, low - box.high[axis] - kPad});
}

void Vicinity::add(const Box& box, double reach) {
  const bool few = ++count_ <= kFewBoxes;
  if (few) boxes_.push_back({box, reach * reach});
  const double wide = reach + kPad;
  const auto range = [&](int axis, double on_axis) {
    return std::pair(cells_.grid.cell(box.low[axis] - on_axis, axis), cells_.grid.cell(box.high[axis] + on_axis, axis));
  };
  const auto [x0, x1] = range(0, wide);
  const auto [y0, y1] = range(1, wide);
  const auto [z0, z1] = range(2, wide);
  rows_marked_ += std::size_t{1} * (z1 - z0 + 1) * (y1 - y0 + 1);
  if (rows_marked_ > kMostMarked) return;
  first_ = {std::min(first_[0], x0), std::min(first_[1], y0), std::min(first_[2], z0)};
  last_ = {std::max(last_[0], x1), std::max(last_[1], y1), std::max(last_[2], z1)};
  std::array<double, MeshCells::kMost> gap_y;
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
  const auto high = [&](std::uint32_t axis) { return std::min(last_[axis] + kRing, cells_.grid.cells - 1); };
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
  close_.back() = ~std::uint64_t{0};
}

// Whether a cell in the box of the corners' cells is marked.
bool Vicinity::marked(const Triangle& triangle) const {
  const std::uint32_t a = cells_.packed[triangle[0]], b = cells_.packed[triangle[1]], c = cells_.packed[triangle[2]];
  const auto range = [&](unsigned axis) {  // of cells that are in the widened boxes' range, too
    const unsigned shift = 8 * axis;
    const auto [low, high] = std::minmax({a >> shift & 63U, b >> shift & 63U, c >> shift & 63U});
    return std::pair(std::max(low, first_[axis]), std::min(high, last_[axis]));
  };
  const auto [x0, x1] = range(0);
  const auto [y0, y1] = range(1);
  const auto [z0, z1] = range(2);
  if (x0 > x1 || y0 > y1 || z0 > z1) return false;
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
    return squared_norm(gap) <= near.reach_sq * kNearer + kLeast;
  });
}

std::optional<std::vector<std::uint32_t>> Vicinity::triangles(const Interrupted& interrupted) {
  std::vector<std::uint32_t> found;
  if (count_ > 0 && rows_marked_ <= kMostMarked) find_close();
  const bool all = rows_marked_ > kMostMarked, by_cells = count_ > kFewerBoxes;
  const auto see = [&, places = cells_.places.data(), close = close_.data()](std::uint32_t t) {
    if (!all) {
      if ((close[places[t] / MeshCells::kMost] >> places[t] % MeshCells::kMost & 1) == 0) return;
      if (by_cells && !marked(cells_.mesh.triangles[t])) return;
    }
    if (count_ <= kFewBoxes && !within(box_of(cells_.mesh, t, cells_.frame))) return;
    found.push_back(t);
  };
  return each_unless(interrupted, cells_.mesh.triangles.size(), see) ? std::optional(std::move(found)) : std::nullopt;
}

}  // namespace meshgauge
