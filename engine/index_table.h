// Hashing of positions and of what is made of them.
#pragma once

#include <bit>
#include <cstdint>

#include "engine/large_array.h"
#include "engine/mesh.h"

namespace meshgauge {

inline std::uint64_t mix(std::uint64_t x) {
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  return x ^ (x >> 32);
}

// Drawn once a process, so that nobody can make a mesh whose vertices collide. No result depends on it.
std::uint64_t hash_seed();

inline std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t hash = hash_seed();
  for (int k = 0; k < 3; ++k) hash = mix(hash ^ std::bit_cast<std::uint64_t>(p[k] + 0.0));  // -0 equals 0
  return hash;
}

// Open addressing over indices: maps a key to the index first stored with it.
class IndexTable {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  explicit IndexTable(std::size_t expected) : slots_(std::bit_ceil(2 * expected + 2), kNone) {}

  // The index stored under an equal key, or kNone.
  template <class Equal>
  std::uint32_t find(std::uint64_t hash, Equal&& equal) const {
    return slots_[place_of(hash, equal)];
  }

  // The index stored under an equal key, or kNone after storing `index`.
  template <class Equal>
  std::uint32_t find_or_store(std::uint64_t hash, std::uint32_t index, Equal&& equal) {
    std::uint32_t& slot = slots_[place_of(hash, equal)];
    if (slot != kNone) return slot;
    slot = index;
    return kNone;
  }

  std::size_t bytes() const { return bytes_of(slots_); }

 private:
  template <class Equal>
  std::size_t place_of(std::uint64_t hash, Equal&& equal) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = hash & mask;
    while (slots_[i] != kNone && !equal(slots_[i])) i = (i + 1) & mask;
    return i;
  }

  LargeArray<std::uint32_t> slots_;
};

}  // namespace meshgauge
