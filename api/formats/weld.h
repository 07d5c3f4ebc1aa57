// Merges vertices whose three coordinates are equal. -0.0 equals 0.0 and becomes 0.0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/mesh.h"
#include "engine/mesh/large_array.h"

namespace meshgauge::api {

// Takes positions block by block and keeps those that differ, in the order in which they first occur. Expected linear
// time for any positions. The result does not depend on the blocks.
class Welder {
 public:
  // `kept`: the array for the positions kept, borrowed, with room for all that add() gets. `expected`: about how many
  // will be kept; sizes the table, which grows with their number.
  Welder(Vec3* kept, std::size_t expected);

  // Writes to indices[i] the index of positions[i] among those kept. Precondition: no NaN, fewer than 2^32 - 1
  // positions in all calls together. The positions may lie in `kept` themselves, if each call continues where the call
  // before ended, from the start of `kept`.
  void add(std::span<const Vec3> positions, std::uint32_t* indices);

  std::size_t count() const { return count_; }  // positions kept so far

 private:
  void add_block(std::span<const Vec3> positions, std::uint32_t* indices);
  std::uint32_t index_of(const Vec3& p, std::uint64_t hash);
  std::uint64_t hash(const Vec3& p) const;
  void make_table(std::size_t slots);
  void grow();

  Vec3* kept_;
  std::uint32_t count_ = 0;
  // Open addressing: each slot is free or has the index of a position kept. At least half of the slots are free.
  LargeArray<std::uint32_t> table_;
  std::uint64_t seed_;
};

// Merges the vertices of a mesh. Keeps every triangle, also those that become degenerate. Returns the number of
// vertices removed. Precondition: indices in range, no NaN. Allocates two arrays of indices.
std::size_t weld(Mesh& mesh);

}  // namespace meshgauge::api
