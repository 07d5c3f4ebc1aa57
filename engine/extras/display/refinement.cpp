#include "engine/extras/display/refinement.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <unordered_map>

namespace meshgauge {
namespace {

constexpr int kMostRounds = 64;  // each halves the longest edges; max_triangles ends it long before

double length(const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  return scaled_norm(mesh.positions[b] - mesh.positions[a]);
}

double longest_edge(const Mesh& mesh) {
  double longest = 0;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, length(mesh, t[i], t[(i + 1) % 3]));
  }
  return longest;
}

// One pass over all triangles that splits every edge longer than a threshold.
class Round {
 public:
  Round(Mesh& mesh, double threshold) : mesh_(mesh), threshold_(threshold) {}

  // Splits the long edges. False: the result would have more than `max_triangles`; the mesh is unchanged.
  bool split(std::size_t max_triangles) {
    std::size_t count = 0;
    for (const Triangle& t : mesh_.triangles) count += 1 + static_cast<std::size_t>(std::popcount(long_edges(t)));
    if (count > max_triangles) return false;
    triangles_.reserve(count);
    for (const Triangle& t : mesh_.triangles) split(t);
    mesh_.triangles.swap(triangles_);
    return true;
  }

 private:
  // Bit i: the edge from corner i to the next.
  unsigned long_edges(const Triangle& t) const {
    unsigned mask = 0;
    for (unsigned i = 0; i < 3; ++i) mask |= length(mesh_, t[i], t[(i + 1) % 3]) > threshold_ ? 1U << i : 0U;
    return mask;
  }

  std::uint32_t middle(std::uint32_t a, std::uint32_t b) {
    const std::uint64_t edge = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [found, is_new] = middles_.try_emplace(edge, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) mesh_.positions.emplace_back(mesh_.positions[a] / 2 + mesh_.positions[b] / 2);
    return found->second;
  }

  void split(const Triangle& t) {
    const unsigned mask = long_edges(t);
    if (mask == 0) {
      triangles_.push_back(t);
    } else if (mask == 7) {
      const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
      triangles_.insert(triangles_.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    } else if (std::has_single_bit(mask)) {
      split_one(turned(t, static_cast<unsigned>(std::countr_zero(mask))));
    } else {
      split_two(turned(t, static_cast<unsigned>(std::countr_zero(7U & ~mask)) + 1));
    }
  }

  static Triangle turned(const Triangle& t, unsigned first) {
    return {t[first % 3], t[(first + 1) % 3], t[(first + 2) % 3]};
  }

  // Splits the edge ab.
  void split_one(const Triangle& t) {
    const std::uint32_t ab = middle(t[0], t[1]);
    triangles_.insert(triangles_.end(), {{t[0], ab, t[2]}, {ab, t[1], t[2]}});
  }

  // Splits the edges ab and bc; the quadrangle that is left is cut along its shorter diagonal.
  void split_two(const Triangle& t) {
    const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]);
    triangles_.push_back({ab, t[1], bc});
    if (length(mesh_, t[0], bc) < length(mesh_, ab, t[2])) {
      triangles_.insert(triangles_.end(), {{t[0], ab, bc}, {t[0], bc, t[2]}});
    } else {
      triangles_.insert(triangles_.end(), {{t[0], ab, t[2]}, {ab, bc, t[2]}});
    }
  }

  Mesh& mesh_;
  const double threshold_;
  std::vector<Triangle> triangles_;
  std::unordered_map<std::uint64_t, std::uint32_t> middles_;  // by edge
};

}  // namespace

std::optional<Mesh> refined(MeshView mesh, const Refinement& wanted, const Interrupted& interrupted) {
  if (mesh.triangles.size() >= wanted.max_triangles) return std::nullopt;
  Mesh result{{mesh.positions.begin(), mesh.positions.end()}, {mesh.triangles.begin(), mesh.triangles.end()}};
  for (int round = 0; round < kMostRounds && !interrupted(); ++round) {
    const double longest = longest_edge(result);
    if (longest <= wanted.longest_edge) break;
    if (!Round(result, std::max(wanted.longest_edge, longest / 2)).split(wanted.max_triangles)) break;
  }
  if (result.triangles.size() == mesh.triangles.size()) return std::nullopt;
  return result;
}

}  // namespace meshgauge
