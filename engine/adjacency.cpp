#include "engine/adjacency.h"

#include <bit>
#include <random>

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

std::uint64_t mix(std::uint64_t x) {
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  return x ^ (x >> 32);
}

// Open addressing over indices: maps a key to the index first seen with it.
class IndexTable {
 public:
  explicit IndexTable(std::size_t expected) : slots_(std::bit_ceil(2 * expected + 2), kNone) {}

  // The index stored under an equal key, or kNone after storing `index`.
  template <class Equal>
  std::uint32_t find_or_store(std::uint64_t hash, std::uint32_t index, Equal&& equal) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = hash & mask;; i = (i + 1) & mask) {
      if (slots_[i] == kNone) return slots_[i] = index, kNone;
      if (equal(slots_[i])) return slots_[i];
    }
  }

 private:
  std::vector<std::uint32_t> slots_;
};

// Drawn once a process, so that nobody can make a mesh whose vertices collide. The result does not depend on it.
std::uint64_t seed() {
  static const std::uint64_t value = (std::uint64_t{std::random_device{}()} << 32) | std::random_device{}();
  return value;
}

std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t hash = seed();
  for (int k = 0; k < 3; ++k) hash = mix(hash ^ std::bit_cast<std::uint64_t>(p[k] + 0.0));  // -0 equals 0
  return hash;
}

// For each vertex that triangles use, the first one at its position. The others may be anything, NaN too.
std::vector<std::uint32_t> weld(MeshView mesh) {
  std::vector<std::uint32_t> vertex(mesh.positions.size(), kNone);
  IndexTable table(std::min(mesh.positions.size(), 3 * mesh.triangles.size()));
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t i : triangle) {
      if (vertex[i] != kNone) continue;
      const Vec3& p = mesh.positions[i];
      const auto seen = table.find_or_store(hash_of(p), i, [&](std::uint32_t j) { return mesh.positions[j] == p; });
      vertex[i] = seen == kNone ? i : seen;
    }
  }
  return vertex;
}

}  // namespace

Adjacency::Adjacency(MeshView mesh) : next_(3 * mesh.triangles.size()) {
  const std::vector<std::uint32_t> vertex = weld(mesh);
  const auto ends = [&](std::uint32_t half_edge) {
    const Triangle& t = mesh.triangles[half_edge / 3];
    const std::uint32_t a = vertex[t[half_edge % 3]], b = vertex[t[(half_edge + 1) % 3]];
    return a < b ? std::pair(a, b) : std::pair(b, a);
  };
  IndexTable table(next_.size());
  for (std::uint32_t h = 0; h < next_.size(); ++h) {
    next_[h] = h;
    const auto key = ends(h);
    const std::uint64_t hash = mix(seed() ^ ((std::uint64_t{key.first} << 32) | key.second));
    const auto first = table.find_or_store(hash, h, [&](std::uint32_t g) { return ends(g) == key; });
    if (first != kNone) std::swap(next_[h], next_[first]);  // into the ring, behind its first
  }
}

}  // namespace meshgauge
