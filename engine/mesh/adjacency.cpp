#include "engine/mesh/adjacency.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "engine/mesh/index_table.h"
#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = IndexTable::kNone;

constexpr std::size_t kAskEvery = std::size_t{1} << 17;  // triangles or vertices, about 3 ms
constexpr std::size_t kRange = std::size_t{1} << 12;     // vertices

// Calls work(share) on all threads, once for each of as many shares. False: one of them was interrupted.
template <class Work>
bool each_share(ThreadPool& pool, const Work& work) {
  std::atomic<bool> complete{true};
  pool.run(pool.size(), [&](std::size_t, std::size_t share) {
    if (!work(share)) complete = false;
  });
  return complete;
}

// The hashes of the mesh's positions. They are divided into shares, one for each thread, by their value.
struct Hashes {
  LargeArray<std::uint64_t> of_position;
  std::vector<std::atomic<std::size_t>> counts;  // by share: the number of its positions

  std::size_t share_of(std::size_t v) const { return ((of_position[v] >> 32) * counts.size()) >> 32; }
};

bool hash_positions(MeshView mesh, ThreadPool& pool, const Interrupted& interrupted, Hashes& hashes) {
  hashes.of_position.resize(mesh.positions.size());
  return each_range(interrupted, mesh.positions.size(), kRange, pool, [&](std::size_t first, std::size_t last) {
    std::vector<std::size_t> counts(hashes.counts.size());
    for (std::size_t v = first; v < last; ++v) {
      hashes.of_position[v] = hash_of(mesh.positions[v]);
      ++counts[hashes.share_of(v)];
    }
    for (std::size_t share = 0; share < counts.size(); ++share) hashes.counts[share] += counts[share];
  });
}

// Sets `vertex` to the first vertex at the same position, for each vertex. False: interrupted.
bool weld(MeshView mesh, ThreadPool& pool, const Interrupted& interrupted, LargeArray<std::uint32_t>& vertex) {
  Hashes hashes{{}, std::vector<std::atomic<std::size_t>>(pool.size())};
  if (!hash_positions(mesh, pool, interrupted, hashes)) return false;
  const std::span<const Vec3> positions = mesh.positions;
  vertex.resize(positions.size());
  return each_share(pool, [&](std::size_t share) {
    IndexTable table(hashes.counts[share]);
    const auto find = [&](std::uint32_t v) {
      if (hashes.share_of(v) != share) return;
      const auto seen =
          table.find_or_store(hashes.of_position[v], v, [&](std::uint32_t u) { return positions[u] == positions[v]; });
      vertex[v] = seen == kNone ? v : seen;
    };
    return each_unless(interrupted, positions.size(), find, kAskEvery);
  });
}

// A half-edge in the list of the lower of its two welded ends.
struct Filed {
  std::uint32_t higher_end;
  std::uint32_t half_edge;
};

// All half-edges, grouped by their lower end: those of vertex v are [begin[v], begin[v + 1]). The last begin has no
// meaning.
struct Files {
  LargeArray<std::uint32_t> begin;
  LargeArray<Filed> entries;
};

// Each thread goes over all triangles and files under its share of the vertices. False: interrupted.
bool file_by_lower_end(MeshView mesh, const LargeArray<std::uint32_t>& vertex, ThreadPool& pool,
                       const Interrupted& interrupted, Files& files) {
  const std::size_t size = vertex.size() / pool.size() + 1;
  const auto for_each = [&](auto&& visit) {
    return each_share(pool, [&](std::size_t share) {
      const std::size_t begin = share * size;
      const auto of_triangle = [=, triangles = mesh.triangles, first = vertex.data()](std::uint32_t t) {
        const std::array corners{first[triangles[t][0]], first[triangles[t][1]], first[triangles[t][2]]};
        for (std::uint32_t i = 0; i < 3; ++i) {
          const std::uint32_t a = corners[i], b = corners[(i + 1) % 3], lower = std::min(a, b);
          if (lower - begin < size) visit(lower, Filed{std::max(a, b), 3 * t + i});
        }
      };
      return each_unless(interrupted, mesh.triangles.size(), of_triangle, kAskEvery);
    });
  };
  files.begin.assign(vertex.size() + 2, 0);
  files.entries.resize(3 * mesh.triangles.size());
  std::uint32_t* const next = files.begin.data() + 1;  // by vertex: where its next half-edge goes
  if (!for_each([next](std::uint32_t v, Filed) { ++next[v + 1]; })) return false;
  for (std::size_t v = 1; v < vertex.size(); ++v) next[v] += next[v - 1];
  return for_each([next, entries = files.entries.data()](std::uint32_t v, Filed entry) { entries[next[v]++] = entry; });
}

// Sorts by the higher end, and those of one edge as they are: by their numbers. Mostly there are six.
void sort(Filed* first, Filed* last) {
  constexpr std::ptrdiff_t kFew = 16;
  const auto before = [](const Filed& a, const Filed& b) { return a.higher_end < b.higher_end; };
  if (last - first > kFew) return std::stable_sort(first, last, before);
  for (Filed* entry = first; entry != last; ++entry) {
    const Filed moved = *entry;
    Filed* place = entry;
    for (; place != first && before(moved, place[-1]); --place) *place = place[-1];
    *place = moved;
  }
}

// Links the half-edges first..last, which share their lower end, into a ring for each higher end.
void link(Filed* first, Filed* last, std::uint32_t* next_around) {
  sort(first, last);
  for (Filed* entry = first; entry != last;) {
    Filed* next = entry + 1;
    while (next != last && next->higher_end == entry->higher_end) ++next;
    for (Filed* e = entry; e + 1 != next; ++e) next_around[e->half_edge] = (e + 1)->half_edge;
    next_around[(next - 1)->half_edge] = entry->half_edge;
    entry = next;
  }
}

}  // namespace

Adjacency::Adjacency(MeshView mesh, ThreadPool& pool, const Interrupted& interrupted)
    : next_(3 * mesh.triangles.size()) {
  LargeArray<std::uint32_t> vertex;
  Files files;
  if (!weld(mesh, pool, interrupted, vertex) || !file_by_lower_end(mesh, vertex, pool, interrupted, files)) return;
  complete_ = each_range(interrupted, mesh.positions.size(), kRange, pool, [&](std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      link(files.entries.data() + files.begin[v], files.entries.data() + files.begin[v + 1], next_.data());
    }
  });
}

}  // namespace meshgauge
