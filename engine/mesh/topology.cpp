#include "engine/mesh/topology.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/mesh/index_table.h"
#include "engine/mesh/large_array.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = IndexTable::kNone;
using rounding::down;
using rounding::up;
using Vertices = LargeArray<std::uint32_t>;

// Returns for each vertex that a triangle uses the first one at its position, else kNone. Empty: interrupted.
Vertices first_at_position(MeshView mesh, const Interrupted& interrupted) {
  Vertices first(mesh.positions.size(), kNone);
  IndexTable table(mesh.positions.size());
  const bool done = each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (first[v] != kNone) continue;
      const Vec3& p = mesh.positions[v];
      const auto known = table.find_or_store(hash_of(p), v, [&](std::uint32_t u) { return mesh.positions[u] == p; });
      first[v] = known == kNone ? v : known;
    }
  });
  return done ? first : Vertices();
}

// Calls visit(a, b) for the three edges of each triangle, from vertex a to vertex b. False: interrupted.
template <class Visit>
bool each_edge(MeshView mesh, const Vertices& first, const Interrupted& interrupted, Visit&& visit) {
  return each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
    const Triangle& triangle = mesh.triangles[t];
    const std::uint32_t a = first[triangle[0]], b = first[triangle[1]], c = first[triangle[2]];
    if (a == b || b == c || c == a) return;
    visit(a, b), visit(b, c), visit(c, a);
  });
}

// Values grouped by a key, in the order of their coming: those of key k are [begin(k), begin(k + 1)) of `values`.
struct Groups {
  LargeArray<std::uint32_t> end;  // by key
  LargeArray<std::uint32_t> values;

  std::uint32_t begin(std::size_t key) const { return key == 0 ? 0 : end[key - 1]; }

  // `each` calls its argument with each key and value, at most `most` times, the same every time, and returns false
  // when interrupted; so does this.
  template <class Each>
  bool fill(std::size_t keys, std::size_t most, const Each& each) {
    end.assign(keys + 1, 0);
    values.resize(most);
    if (!each([&](std::uint32_t key, std::uint32_t) { ++end[key + 1]; })) return false;
    for (std::size_t key = 1; key <= keys; ++key) end[key] += end[key - 1];
    return each([&](std::uint32_t key, std::uint32_t value) { values[end[key]++] = value; });
  }
};

// An edge as its ends see it: the other end, and whether it is passed from the lower end to the higher one.
std::uint32_t coded(std::uint32_t other_end, bool rising) {
  return other_end << 1 | static_cast<std::uint32_t>(rising);
}

// Groups all passes of edges by their lower end, those of a lower end by their higher one: two passes of a counting
// sort, since a sort of the edges of one vertex could take long without polling. False: interrupted.
bool group_edges(MeshView mesh, const Vertices& first, const Interrupted& interrupted, Groups& by_lower) {
  const std::size_t most = 3 * mesh.triangles.size();
  Groups by_higher;
  const bool grouped = by_higher.fill(first.size(), most, [&](auto&& visit) {
    return each_edge(mesh, first, interrupted,
                     [&](std::uint32_t a, std::uint32_t b) { visit(std::max(a, b), coded(std::min(a, b), a < b)); });
  });
  return grouped && by_lower.fill(first.size(), most, [&](auto&& visit) {
    return each_unless(interrupted, first.size(), [&](std::uint32_t higher) {
      for (std::uint32_t i = by_higher.begin(higher); i < by_higher.end[higher]; ++i)
        visit(by_higher.values[i] >> 1, coded(higher, by_higher.values[i] & 1));
    });
  });
}

void count(EdgeCount& kind, const Vec3& a, const Vec3& b) {
  if (kind.count++ == 0) kind.first = a / 2 + b / 2;
}

// Counts the edges of each kind. False: interrupted.
bool count_edges(MeshView mesh, const Groups& by_lower, std::size_t vertices, const Interrupted& interrupted,
                 Topology& found) {
  return each_unless(interrupted, vertices, [&](std::uint32_t lower) {
    const std::uint32_t end = by_lower.end[lower];
    for (std::uint32_t i = by_lower.begin(lower); i < end;) {
      const std::uint32_t higher = by_lower.values[i] >> 1;
      std::size_t passes = 0, rising = 0;
      for (; i < end && by_lower.values[i] >> 1 == higher; ++i, ++passes) rising += by_lower.values[i] & 1;
      const Vec3 &a = mesh.positions[lower], &b = mesh.positions[higher];
      ++found.edges;
      if (passes == 1) count(found.open, a, b);
      if (passes > 2) count(found.non_manifold, a, b);
      if (rising > 1 || passes - rising > 1) count(found.flipped, a, b);
    }
  });
}

// Disjoint sets of vertices. A set's root is its lowest vertex.
class Sets {
 public:
  explicit Sets(std::size_t vertices) : parent_(vertices, kNone) {}

  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    if (a == b) return;
    parent_[std::max(a, b)] = std::min(a, b);
    --sets_;
  }
  std::size_t vertices() const { return vertices_; }
  std::size_t sets() const { return sets_; }

 private:
  std::uint32_t root(std::uint32_t v) {
    if (parent_[v] == kNone) parent_[v] = v, ++vertices_, ++sets_;
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }

  LargeArray<std::uint32_t> parent_;  // kNone: in no set
  std::size_t vertices_ = 0, sets_ = 0;
};

// Six times a volume, and the sum of the absolute values of the products that it is made of.
struct Determinant {
  double value = 0;
  double size = 0;
};

Determinant determinant(const Vec3& a, const Vec3& b, const Vec3& c) {
  Determinant all;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const double one = b[l] * c[m], other = b[m] * c[l];
    all.value += a[k] * (one - other);
    all.size += std::abs(a[k]) * (std::abs(one) + std::abs(other));
  }
  return all;
}

// Returns x * 2^exponent, rounded towards +infinity.
double scaled_up(double x, int exponent) {
  return x < 0 ? -rounding::scale_down(-x, exponent) : rounding::scale_up(x, exponent);
}

// Sums the determinants in the frame of R14 (engine/rounding.h), in blocks. nullopt: interrupted.
std::optional<Volume> volume_of(MeshView mesh, const Box& box, const Interrupted& interrupted) {
  const Vec3 origin = box.low / 2 + box.high / 2;
  int exponent = 0;
  std::frexp((box.high - box.low).maxCoeff(), &exponent);
  exponent = std::max(exponent, rounding::kSmallestVolumeExponent);
  const double scale = std::ldexp(1.0, -exponent);
  Determinant all, block;
  const auto end_block = [&] {
    all.value += block.value;
    all.size += block.size;
    block = {};
  };
  const bool done = each_unless(interrupted, mesh.triangles.size(), [&](std::uint32_t t) {
    const Vec3& p = mesh.corner(t, 0);
    const Determinant one =
        determinant((p - origin) * scale, (mesh.corner(t, 1) - p) * scale, (mesh.corner(t, 2) - p) * scale);
    block.value += one.value;
    block.size += one.size;
    if (t % rounding::kVolumeBlock == rounding::kVolumeBlock - 1) end_block();
  });
  if (!done) return std::nullopt;
  end_block();
  const double error = rounding::volume_error(mesh.triangles.size(), all.size);
  const double lower = down(down(all.value - error) / 6), upper = up(up(all.value + error) / 6);
  return Volume{-scaled_up(-lower, 3 * exponent), scaled_up(upper, 3 * exponent)};
}

}  // namespace

std::optional<Topology> topology(MeshView mesh, const Box& box, const Interrupted& interrupted) {
  const Vertices first = first_at_position(mesh, interrupted);
  if (first.size() != mesh.positions.size()) return std::nullopt;
  Topology found;
  {
    Groups by_lower;
    if (!group_edges(mesh, first, interrupted, by_lower)) return std::nullopt;
    if (!count_edges(mesh, by_lower, first.size(), interrupted, found)) return std::nullopt;
  }
  Sets sets(first.size());
  std::size_t passes = 0;
  const bool joined = each_edge(mesh, first, interrupted, [&](std::uint32_t a, std::uint32_t b) {
    sets.join(a, b);
    ++passes;
  });
  if (!joined) return std::nullopt;
  found.components = sets.sets();
  found.euler_characteristic = static_cast<std::int64_t>(sets.vertices()) - static_cast<std::int64_t>(found.edges) +
                               static_cast<std::int64_t>(passes / 3);
  if (found.watertight() && found.oriented()) {
    found.volume = volume_of(mesh, box, interrupted);
    if (!found.volume) return std::nullopt;
  }
  return found;
}

Topology scaled(Topology topology, const Factor& factor) {
  if (factor.is_one()) return topology;
  for (EdgeCount* kind : {&topology.open, &topology.non_manifold, &topology.flipped})
    kind->first = kind->first * factor.times / factor.over;
  for (int k = 0; topology.volume && k < 3; ++k) {
    auto& [lower, upper] = *topology.volume;
    lower = down(down(lower * factor.times) / factor.over);
    upper = up(up(upper * factor.times) / factor.over);
  }
  return topology;
}

}  // namespace meshgauge
