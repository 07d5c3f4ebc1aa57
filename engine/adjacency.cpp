#include "engine/adjacency.h"

#include <algorithm>

#include "engine/index_table.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = IndexTable::kNone;

// For each vertex that triangles use, the first one at its position. The others may be anything, NaN too.
LargeArray<std::uint32_t> weld(MeshView mesh) {
  LargeArray<std::uint32_t> vertex(mesh.positions.size(), kNone);
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

Files file_by_lower_end(MeshView mesh, const LargeArray<std::uint32_t>& vertex) {
  const auto for_each = [&](auto&& visit) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = vertex[mesh.triangles[t][i]], b = vertex[mesh.triangles[t][(i + 1) % 3]];
        visit(std::min(a, b), Filed{std::max(a, b), 3 * t + i});
      }
    }
  };
  Files files{LargeArray<std::uint32_t>(vertex.size() + 1, 0), LargeArray<Filed>(3 * mesh.triangles.size())};
  for_each([&](std::uint32_t v, Filed) { ++files.begin[v + 1]; });
  for (std::size_t v = 1; v < files.begin.size(); ++v) files.begin[v] += files.begin[v - 1];
  LargeArray<std::uint32_t> end(files.begin.begin(), files.begin.end() - 1);
  for_each([&](std::uint32_t v, Filed entry) { files.entries[end[v]++] = entry; });
  return files;
}

}  // namespace

Adjacency::Adjacency(MeshView mesh) : next_(3 * mesh.triangles.size()) {
  Files files = file_by_lower_end(mesh, weld(mesh));
  for (std::size_t v = 0; v + 1 < files.begin.size(); ++v) {
    const auto first = files.entries.begin() + files.begin[v], last = files.entries.begin() + files.begin[v + 1];
    std::sort(first, last, [](const Filed& a, const Filed& b) {
      return std::pair(a.higher_end, a.half_edge) < std::pair(b.higher_end, b.half_edge);
    });
    for (auto entry = first; entry != last;) {
      auto next = entry + 1;
      while (next != last && next->higher_end == entry->higher_end) ++next;
      for (auto e = entry; e + 1 != next; ++e) next_[e->half_edge] = (e + 1)->half_edge;
      next_[(next - 1)->half_edge] = entry->half_edge;  // the ring is closed
      entry = next;
    }
  }
}

}  // namespace meshgauge
