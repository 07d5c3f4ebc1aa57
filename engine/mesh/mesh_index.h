// Look-up of positions and of whole triangles in a mesh, by exact coordinates. -0 equals 0.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/mesh/index_table.h"
#include "engine/mesh/large_array.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// The positions of a mesh, whether a triangle uses them or not.
class PositionIndex {
 public:
  // Borrows `mesh`. Linear time. If it is interrupted, complete() is false and it must not be used.
  PositionIndex(MeshView mesh, const Interrupted& interrupted);
  bool complete() const { return complete_; }

  bool holds(const Vec3& p) const;
  std::size_t bytes() const { return table_.bytes(); }

 private:
  MeshView mesh_;
  IndexTable table_;
  bool complete_;
};

// The triangles of a mesh by their three corners, in any order.
class TriangleIndex {
 public:
  static constexpr std::uint32_t kNone = IndexTable::kNone;

  // Borrows `mesh`. Linear time. If it is interrupted, complete() is false and it must not be used.
  TriangleIndex(MeshView mesh, const Interrupted& interrupted);
  bool complete() const { return complete_; }

  // Returns the first triangle of the mesh with the corners of `from`'s triangle t, or kNone.
  std::uint32_t find(MeshView from, std::size_t t) const;
  std::size_t bytes() const { return table_.bytes() + bytes_of(hashes_); }

 private:
  auto is_equal(std::uint64_t hash, MeshView from, std::size_t t) const;

  MeshView mesh_;
  IndexTable table_;
  LargeArray<std::uint64_t> hashes_;  // by triangle
  bool complete_;
};

// Whether triangle s of `a` and triangle t of `b` have the same corners, in any order.
bool same_corners(MeshView a, std::size_t s, MeshView b, std::size_t t);

// Calls visit(i) for each i below `count` and polls `interrupted` at least every 5 ms: after `ask_every` calls. False:
// interrupted.
template <class Visit>
bool each_unless(const Interrupted& interrupted, std::size_t count, Visit&& visit,
                 std::size_t ask_every = std::size_t{1} << 13) {
  for (std::size_t begin = 0; begin < count; begin += ask_every) {
    if (begin > 0 && interrupted()) return false;
    const std::size_t end = std::min(begin + ask_every, count);
    for (std::size_t i = begin; i < end; ++i) visit(static_cast<std::uint32_t>(i));
  }
  return true;
}

// Calls visit(first, last) on all threads of the pool, for ranges of `size` that make up [0, count), and polls
// `interrupted` before each. False: interrupted.
template <class Visit>
bool each_range(const Interrupted& interrupted, std::size_t count, std::size_t size, ThreadPool& pool, Visit&& visit) {
  std::atomic<bool> complete{true};
  pool.run((count + size - 1) / size, [&](std::size_t, std::size_t range) {
    if (!complete || interrupted()) {
      complete = false;
    } else {
      visit(range * size, std::min((range + 1) * size, count));
    }
  });
  return complete;
}

}  // namespace meshgauge
