#include "engine/morton.h"

#include <algorithm>
#include <array>
#include <utility>

namespace meshgauge {
namespace {

// 10 bits spread to every third place.
std::uint32_t spread(std::uint32_t x) {
  x = (x | (x << 16)) & 0x030000FF;
  x = (x | (x << 8)) & 0x0300F00F;
  x = (x | (x << 4)) & 0x030C30C3;
  return (x | (x << 2)) & 0x09249249;
}

using Keyed = std::pair<std::uint32_t, std::uint32_t>;  // code, triangle

// Stable, by 10 bits at a time.
void radix_sort(std::vector<Keyed>& items) {
  constexpr std::uint32_t kBuckets = 1024;
  std::vector<Keyed> other(items.size());
  for (std::uint32_t shift = 0; shift < 30; shift += 10) {
    std::array<std::size_t, kBuckets + 1> start{};
    for (const Keyed& item : items) ++start[((item.first >> shift) & (kBuckets - 1)) + 1];
    for (std::size_t b = 0; b < kBuckets; ++b) start[b + 1] += start[b];
    for (const Keyed& item : items) other[start[(item.first >> shift) & (kBuckets - 1)]++] = item;
    items.swap(other);
  }
}

}  // namespace

std::vector<std::uint32_t> morton_order(MeshView mesh, const Box& box) {
  const double size = std::max((box.high - box.low).maxCoeff(), 0x1p-500);
  std::vector<Keyed> items(mesh.triangles.size());
  for (std::uint32_t t = 0; t < items.size(); ++t) {
    const Vec3 centre = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    std::uint32_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const double cell = (centre[k] - box.low[k]) / size * 1024;
      code |= spread(static_cast<std::uint32_t>(std::clamp(cell, 0.0, 1023.0))) << k;
    }
    items[t] = {code, t};
  }
  radix_sort(items);
  std::vector<std::uint32_t> order(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) order[i] = items[i].second;
  return order;
}

}  // namespace meshgauge
