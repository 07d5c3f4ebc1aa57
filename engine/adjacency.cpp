#include "engine/adjacency.h"

#include <algorithm>

#include "engine/index_table.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = IndexTable::kNone;

constexpr std::size_t kAskEvery = std::size_t{1} << 17;  // triangles or vertices, about 3 ms

// Calls visit(i) for each i below `count`. False: interrupted.
template <class Visit>
bool each(std::size_t count, const Interrupted& interrupted, Visit&& visit) {
  for (std::size_t begin = 0; begin < count; begin += kAskEvery) {
    if (begin > 0 && interrupted()) return false;
    const std::size_t end = std::min(begin + kAskEvery, count);
    for (std::size_t i = begin; i < end; ++i) visit(static_cast<std::uint32_t>(i));
  }
  return true;
}

// Puts into `vertex`, for each vertex that triangles use, the first one at its position. The others may be anything,
// NaN too.
bool weld(MeshView mesh, const Interrupted& interrupted, LargeArray<std::uint32_t>& vertex) {
  vertex.assign(mesh.positions.size(), kNone);
  IndexTable table(std::min(mesh.positions.size(), 3 * mesh.triangles.size()));
  return each(mesh.triangles.size(), interrupted, [&](std::uint32_t t) {
    for (const std::uint32_t i : mesh.triangles[t]) {
      if (vertex[i] != kNone) continue;
      const Vec3& p = mesh.positions[i];
      const auto seen = table.find_or_store(hash_of(p), i, [&](std::uint32_t j) { return mesh.positions[j] == p; });
      vertex[i] = seen == kNone ? i : seen;
    }
  });
}

// A half-edge, filed under the lower of its two (welded) ends.
struct Filed {
  std::uint32_t higher_end;
  std::uint32_t half_edge;
};

// All half-edges, those with the same lower end side by side: `begin[v]` is where those of v begin.
struct Files {
  LargeArray<std::uint32_t> begin;
  LargeArray<Filed> entries;
};

bool file_by_lower_end(MeshView mesh, const LargeArray<std::uint32_t>& vertex, const Interrupted& interrupted,
                       Files& files) {
  const auto for_each = [&](auto&& visit) {
    return each(mesh.triangles.size(), interrupted, [&](std::uint32_t t) {
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = vertex[mesh.triangles[t][i]], b = vertex[mesh.triangles[t][(i + 1) % 3]];
        visit(std::min(a, b), Filed{std::max(a, b), 3 * t + i});
      }
    });
  };
  files.begin.assign(vertex.size() + 1, 0);
  files.entries.resize(3 * mesh.triangles.size());
  if (!for_each([&](std::uint32_t v, Filed) { ++files.begin[v + 1]; })) return false;
  for (std::size_t v = 1; v < files.begin.size(); ++v) files.begin[v] += files.begin[v - 1];
  LargeArray<std::uint32_t> end(files.begin.begin(), files.begin.end() - 1);
  return for_each([&](std::uint32_t v, Filed entry) { files.entries[end[v]++] = entry; });
}

// Links the half-edges first..last, which share their lower end, into a ring for each higher end.
void link(Filed* first, Filed* last, LargeArray<std::uint32_t>& next_around) {
  std::sort(first, last, [](const Filed& a, const Filed& b) {
    return std::pair(a.higher_end, a.half_edge) < std::pair(b.higher_end, b.half_edge);
  });
  for (Filed* entry = first; entry != last;) {
    Filed* next = entry + 1;
    while (next != last && next->higher_end == entry->higher_end) ++next;
    for (Filed* e = entry; e + 1 != next; ++e) next_around[e->half_edge] = (e + 1)->half_edge;
    next_around[(next - 1)->half_edge] = entry->half_edge;
    entry = next;
  }
}

}  // namespace

Adjacency::Adjacency(MeshView mesh, const Interrupted& interrupted) : next_(3 * mesh.triangles.size()) {
  LargeArray<std::uint32_t> vertex;
  Files files;
  if (!weld(mesh, interrupted, vertex) || !file_by_lower_end(mesh, vertex, interrupted, files)) return;
  complete_ = each(mesh.positions.size(), interrupted, [&](std::uint32_t v) {
    link(files.entries.data() + files.begin[v], files.entries.data() + files.begin[v + 1], next_);
  });
}

}  // namespace meshgauge
