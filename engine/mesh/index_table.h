// Hashes of positions, and a hash table of indices.
#pragma once

#include <bit>
#include <cstdint>

#include "engine/mesh.h"
#include "engine/mesh/large_array.h"

namespace meshgauge {

inline std::uint64_t mix(std::uint64_t x) {
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93U;
  return x ^ (x >> 32);
}

// Random numbers drawn once in each process, so that no mesh can be crafted whose vertices collide. No result depends
// on them. The factors are odd.
struct HashSeed {
  HashSeed();
  std::uint64_t value;
  std::uint64_t factors[3];
};
inline const HashSeed hash_seed;

inline std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t hash = hash_seed.value;
  for (int k = 0; k < 3; ++k) {
    const auto bits = std::bit_cast<std::uint64_t>(p[k] + 0.0);  // -0 equals 0
    hash += (bits ^ bits >> 32) * hash_seed.factors[k];          // round coordinates have no lower bits
  }
  return mix(hash);
}

// An open-addressed hash table that maps a key to the index first stored with it. The caller keeps the keys:
// equal(index) tells whether that index has the key looked for. It holds at most the number of keys it was made for.
class IndexTable {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  explicit IndexTable(std::size_t expected) : slots_(std::bit_ceil(2 * expected + 2), kNone) {}

  // Returns the index stored with an equal key, or kNone.
  template <class Equal>
  std::uint32_t find(std::uint64_t hash, Equal&& equal) const {
    return slots_[place_of(hash, equal)];
  }

  // Returns the index stored with an equal key; if there is none, stores `index` and returns kNone.
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
