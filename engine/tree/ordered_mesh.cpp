#include "engine/tree/ordered_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

constexpr unsigned kBits = 10;                       // bits of a cell's number on one axis
constexpr std::size_t kBatch = 256;                  // centres turned into codes at once
constexpr std::size_t kPart = std::size_t{1} << 14;  // items that a thread takes at once, about 0.3 ms
constexpr std::size_t kFewEnough = 8;                // items of one cell that need no order of their own
constexpr std::size_t kWorthRadix = 2048;            // items from which counting beats comparing
constexpr double kSmallestBox = 0x1p-1010;           // a smaller box is not divided into cells
constexpr int kMaxDepth = 8;                         // cells within cells: 1024^8 is beyond what double resolves

constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();  // a vertex without a new number

struct Item {
  std::uint32_t code;
  std::uint32_t triangle;
};

using Cells = std::array<std::array<std::uint32_t, kBatch>, 3>;
using Codes = std::array<std::uint32_t, kBatch>;

// Spreads 10 bits to every third place.
std::uint32_t spread(std::uint32_t x) {
  x = (x | (x << 16)) & 0x030000FF;
  x = (x | (x << 8)) & 0x0300F00F;
  x = (x | (x << 4)) & 0x030C30C3;
  return (x | (x << 2)) & 0x09249249;
}

// J. Skilling, "Programming the Hilbert curve" (2004), without branches, for many points at once.
void hilbert_codes(Cells& cells, std::size_t count, Codes& codes) {
  auto& [x, y, z] = cells;
  for (unsigned bit = kBits - 1; bit > 0; --bit) {
    const std::uint32_t below = (1U << bit) - 1;
    for (std::size_t i = 0; i < count; ++i) {
      x[i] ^= below & (0U - ((x[i] >> bit) & 1U));
      for (auto* other : {&y, &z}) {
        std::uint32_t& o = (*other)[i];
        const std::uint32_t set = 0U - ((o >> bit) & 1U);
        const std::uint32_t swap = (x[i] ^ o) & below & ~set;
        x[i] ^= (below & set) ^ swap;
        o ^= swap;
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t gy = y[i] ^ x[i];
    const std::uint32_t gz = z[i] ^ gy;
    std::uint32_t flip = gz >> 1;  // bit j: parity of the bits of gz above j
    flip ^= flip >> 1;
    flip ^= flip >> 2;
    flip ^= flip >> 4;
    flip ^= flip >> 8;
    codes[i] = (spread(x[i] ^ flip) << 2) | (spread(gy ^ flip) << 1) | spread(gz ^ flip);
  }
}

// Three times the centre of a triangle. Its rounding may change the order, nothing else.
Vec3 centre(MeshView mesh, std::uint32_t triangle) {
  return mesh.corner(triangle, 0) + mesh.corner(triangle, 1) + mesh.corner(triangle, 2);
}

// Sets the items' codes: the numbers, along the curve, of the cells of `box` that hold their centres.
void encode(MeshView mesh, const Box& box, std::span<Item> items) {
  const double size = std::max((box.high - box.low).maxCoeff(), kSmallestBox);
  const double cells_per_unit = (1U << kBits) / size;
  Cells cells;
  Codes codes;
  for (std::size_t begin = 0; begin < items.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, items.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 offset = (centre(mesh, items[begin + i].triangle) - box.low) * cells_per_unit;
      for (std::size_t k = 0; k < 3; ++k) {
        cells[k][i] = static_cast<std::uint32_t>(std::clamp(offset[static_cast<int>(k)], 0.0, (1 << kBits) - 1.0));
      }
    }
    hilbert_codes(cells, count, codes);
    for (std::size_t i = 0; i < count; ++i) items[begin + i].code = codes[i];
  }
}

// Sorts stably by the code, 10 bits at a time. False: interrupted.
bool radix_sort(LargeArray<Item>& items, ThreadPool& pool, const Interrupted& interrupted) {
  constexpr std::uint32_t kBuckets = 1U << kBits;
  using Places = std::array<std::uint32_t, kBuckets>;  // by bucket: first the number of items, then where the next goes
  std::vector<Places> places((items.size() + kPart - 1) / kPart);  // by part
  LargeArray<Item> other(items.size());
  for (unsigned shift = 0; shift < 3 * kBits; shift += kBits) {
    const auto bucket = [shift](const Item& item) { return (item.code >> shift) & (kBuckets - 1); };
    const auto count = [&, from = items.data()](std::size_t begin, std::size_t end) {
      Places& counts = places[begin / kPart];
      counts.fill(0);
      for (std::size_t i = begin; i < end; ++i) ++counts[bucket(from[i])];
    };
    const auto move = [&, from = items.data(), to = other.data()](std::size_t begin, std::size_t end) {
      Places& next = places[begin / kPart];
      for (std::size_t i = begin; i < end; ++i) to[next[bucket(from[i])]++] = from[i];
    };
    if (!each_range(interrupted, items.size(), kPart, pool, count)) return false;
    std::uint32_t before = 0;
    for (std::size_t b = 0; b < kBuckets; ++b) {
      for (Places& part : places) before += std::exchange(part[b], before);
    }
    if (!each_range(interrupted, items.size(), kPart, pool, move)) return false;
    items.swap(other);
  }
  return true;
}

// nullopt: interrupted.
std::optional<Box> box_of_centres(MeshView mesh, std::span<const Item> items, const Interrupted& interrupted) {
  Box box;
  const auto see = [&](std::uint32_t i) { box.extend(centre(mesh, items[i].triangle)); };
  const bool done = each_unless(interrupted, items.size(), see);
  return done ? std::optional(box) : std::nullopt;
}

struct Cell {
  std::size_t begin, end;
  int depth;
};

// Adds the runs of equal codes with more than kFewEnough items to `crowded`.
void find_crowded(std::span<const Item> items, const Cell& within, std::vector<Cell>& crowded) {
  for (std::size_t begin = within.begin; begin < within.end;) {
    std::size_t end = begin + 1;
    while (end < within.end && items[end].code == items[begin].code) ++end;
    if (end - begin > kFewEnough) crowded.push_back({begin, end, within.depth + 1});
    begin = end;
  }
}

bool sort_by_code(std::span<Item> items, ThreadPool& pool, const Interrupted& interrupted) {
  if (items.size() < kWorthRadix) {
    std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
      return std::pair(a.code, a.triangle) < std::pair(b.code, b.triangle);
    });
    return !interrupted();
  }
  LargeArray<Item> copy(items.begin(), items.end());
  if (!radix_sort(copy, pool, interrupted)) return false;
  std::copy(copy.begin(), copy.end(), items.begin());
  return true;
}

// Orders the items that share a cell by a curve through their own box. False: interrupted.
bool refine(MeshView mesh, LargeArray<Item>& items, ThreadPool& pool, const Interrupted& interrupted) {
  std::vector<Cell> crowded;
  find_crowded(items, {0, items.size(), 0}, crowded);
  while (!crowded.empty()) {
    const Cell cell = crowded.back();
    crowded.pop_back();
    const auto inside = std::span(items).subspan(cell.begin, cell.end - cell.begin);
    const std::optional<Box> box = box_of_centres(mesh, inside, interrupted);
    if (!box) return false;
    if (!((box->high - box->low).maxCoeff() > kSmallestBox) || cell.depth > kMaxDepth) continue;
    const auto encode_part = [&](std::size_t begin, std::size_t end) {
      encode(mesh, *box, inside.subspan(begin, end - begin));
    };
    if (!each_range(interrupted, inside.size(), kPart, pool, encode_part)) return false;
    if (!sort_by_code(inside, pool, interrupted)) return false;
    find_crowded(items, cell, crowded);
  }
  return true;
}

}  // namespace

LargeArray<std::uint32_t> curve_order(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& box,
                                      Control& control, ThreadPool& pool) {
  const Interrupted interrupted = [&control] { return control.check() != Interruption::none; };
  LargeArray<Item> items(chosen.empty() ? mesh.triangles.size() : chosen.size());
  const Box of_centres{3 * box.low, 3 * box.high};
  const auto encode_part = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      items[i].triangle = chosen.empty() ? static_cast<std::uint32_t>(i) : chosen[i];
    encode(mesh, of_centres, std::span(items).subspan(begin, end - begin));
  };
  if (!each_range(interrupted, items.size(), kPart, pool, encode_part)) return {};
  if (!radix_sort(items, pool, interrupted) || !refine(mesh, items, pool, interrupted)) return {};
  LargeArray<std::uint32_t> order(items.size());
  const auto take = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) order[i] = items[i].triangle;
  };
  return each_range(interrupted, items.size(), kPart, pool, take) ? std::move(order) : LargeArray<std::uint32_t>();
}

OrderedMesh::OrderedMesh(MeshView mesh, std::span<const std::uint32_t> chosen, const Box& original_box,
                         const Frame& frame, Control& control, ThreadPool& pool)
    : box{frame.to_frame(original_box.low), frame.to_frame(original_box.high)},
      original(curve_order(mesh, chosen, original_box, control, pool)),
      given(mesh.triangles.size()) {
  LargeArray<std::uint32_t> renumbered(mesh.positions.size());
  const auto interrupted = [&] { return control.check() != Interruption::none; };
  const auto forget = [numbers = renumbered.data()](std::uint32_t v) { numbers[v] = kUnseen; };
  if (!each_unless(interrupted, renumbered.size(), forget)) return;
  positions.resize(std::min(mesh.positions.size(), 3 * original.size()));
  triangles.resize(original.size());
  std::uint32_t used = 0;
  const auto take = [&used, mesh, frame, from = original.data(), numbers = renumbered.data(), points = positions.data(),
                     to = triangles.data()](std::uint32_t i) {
    Triangle triangle = mesh.triangles[from[i]];
    for (std::uint32_t& v : triangle) {
      if (numbers[v] == kUnseen) {
        points[used] = frame.to_frame(mesh.positions[v]);
        numbers[v] = used++;
      }
      v = numbers[v];
    }
    to[i] = triangle;
  };
  const bool done = each_unless(interrupted, original.size(), take);
  positions.resize(used);
  if (!done) triangles.clear();
}

}  // namespace meshgauge
