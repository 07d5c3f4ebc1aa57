#include "engine/decimation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/index_table.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::uint64_t kFinest = std::uint64_t{1} << 20;  // cells along the widest axis: three fit into a word
constexpr std::size_t kBlock = std::size_t{1} << 16;       // elements between two looks at the clock
constexpr int kMostGrids = 14;
constexpr double kEnough = 0.7;  // of max_triangles: no further grid is tried
constexpr double kAimedAt = 0.85;

using Corners = std::array<std::uint32_t, 3>;

bool is_smaller(const std::pair<double, std::uint32_t>& a, const std::pair<double, std::uint32_t>& b) {
  return a.first != b.first ? a.first > b.first : a.second < b.second;
}

// The largest triangles as they are.
Decimated largest_of(MeshView mesh, const Box& box, std::size_t count) {
  const double widest = (box.high - box.low).maxCoeff();
  const auto scaled = [&](std::size_t t, int i) -> Vec3 {
    if (widest == 0) return Vec3::Zero();
    return (mesh.corner(t, i) - box.low) / widest;
  };
  std::vector<std::pair<double, std::uint32_t>> order(mesh.triangles.size());
  for (std::uint32_t t = 0; t < order.size(); ++t) {
    const Vec3 e = scaled(t, 1) - scaled(t, 0), f = scaled(t, 2) - scaled(t, 0);
    const Vec3 cross(e.y() * f.z() - e.z() * f.y(), e.z() * f.x() - e.x() * f.z(), e.x() * f.y() - e.y() * f.x());
    order[t] = {cross.norm(), t};
  }
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(std::min(count, order.size()));
  std::partial_sort(order.begin(), end, order.end(), is_smaller);
  Decimated result;
  std::vector<std::uint32_t> names(mesh.positions.size(), kNone);
  for (auto at = order.begin(); at != end; ++at) {
    const std::uint32_t t = at->second;
    const bool flat = is_degenerate(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
    if (flat && at != order.begin()) continue;
    Triangle named{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& name = names[mesh.triangles[t][i]];
      if (name == kNone) {
        name = static_cast<std::uint32_t>(result.source.size());
        result.source.push_back(mesh.triangles[t][i]);
        result.mesh.positions.push_back(mesh.positions[mesh.triangles[t][i]]);
      }
      named[i] = name;
    }
    result.mesh.triangles.push_back(named);
  }
  return result;
}

class Clustering {
 public:
  Clustering(MeshView mesh, const Decimation& wanted, const Box& box, const Interrupted& interrupted)
      : mesh_(mesh),
        wanted_(wanted),
        low_(box.low),
        widest_((box.high - box.low).maxCoeff()),
        interrupted_(interrupted),
        cluster_of_(mesh.positions.size(), kNone) {}

  // Makes the clusters of a grid with `cells` along the widest axis, and says how many triangles they leave; about how
  // many where that is too many. 0 when interrupted.
  double make(std::uint64_t cells) {
    cells_ = cells;
    return assign_clusters() ? collect_triangles() : 0;
  }

  bool stopped() const { return stopped_; }
  double widest() const { return widest_; }

  // Of the clusters made last, which must not be too many.
  Decimated result() {
    choose();
    std::vector<std::uint32_t> names(keys_.size(), kNone);
    Decimated result;
    for (const std::uint32_t t : kept_) add(t, names, result);
    return result;
  }

 private:
  bool look() { return stopped_ = stopped_ || interrupted_(); }

  Vec3 within(std::uint32_t vertex) const { return (mesh_.positions[vertex] - low_) / widest_; }  // from 0 to 1

  std::uint64_t key_of(std::uint32_t vertex) const {
    const Vec3 share = within(vertex) * static_cast<double>(cells_);
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) key = key << 21 | std::min(static_cast<std::uint64_t>(share[k]), cells_ - 1);
    return key;
  }

  bool assign_clusters() {
    const double most = static_cast<double>(cells_) * static_cast<double>(cells_) * static_cast<double>(cells_);
    const auto expected = static_cast<std::size_t>(std::min(most, static_cast<double>(mesh_.positions.size())));
    IndexTable table(expected);
    keys_.clear();
    std::fill(cluster_of_.begin(), cluster_of_.end(), kNone);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (t % kBlock == 0 && look()) return false;
      for (const std::uint32_t vertex : mesh_.triangles[t]) {
        if (cluster_of_[vertex] == kNone) cluster_of_[vertex] = cluster_at(key_of(vertex), table);
      }
    }
    return true;
  }

  std::uint32_t cluster_at(std::uint64_t key, IndexTable& table) {
    const auto next = static_cast<std::uint32_t>(keys_.size());
    const std::uint32_t found =
        table.find_or_store(mix(key ^ hash_seed()), next, [&](std::uint32_t other) { return keys_[other] == key; });
    if (found != IndexTable::kNone) return found;
    keys_.push_back(key);
    return next;
  }

  Corners corners_of(std::uint32_t t) const {
    const Triangle& triangle = mesh_.triangles[t];
    Corners corners{cluster_of_[triangle[0]], cluster_of_[triangle[1]], cluster_of_[triangle[2]]};
    std::sort(corners.begin(), corners.end());
    return corners;
  }

  double collect_triangles() {
    const std::size_t all = mesh_.triangles.size();
    IndexTable table(std::min(all, wanted_.max_triangles + 1));
    kept_.clear();
    for (std::uint32_t t = 0; t < all; ++t) {
      if (t % kBlock == 0 && look()) return 0;
      const Corners c = corners_of(t);
      if (c[0] == c[1] || c[1] == c[2]) continue;
      const std::uint64_t hash = mix(mix(hash_seed() ^ (std::uint64_t{c[0]} << 32 | c[1])) ^ c[2]);
      if (table.find_or_store(hash, t, [&](std::uint32_t o) { return corners_of(o) == c; }) != IndexTable::kNone) {
        continue;
      }
      kept_.push_back(t);
      // The table has room for no more; so goes the rest, by and large.
      if (kept_.size() > wanted_.max_triangles) {
        return std::max(static_cast<double>(kept_.size()),
                        static_cast<double>(kept_.size()) * (static_cast<double>(all) / static_cast<double>(t + 1)));
      }
    }
    return static_cast<double>(kept_.size());
  }

  std::uint8_t rank_of(std::uint32_t vertex) const { return wanted_.rank.empty() ? 0 : wanted_.rank[vertex]; }

  // Of each cluster the vertex that stands for it.
  void choose() {
    std::vector<Vec3> mean(keys_.size(), Vec3::Zero());
    std::vector<double> members(keys_.size(), 0);
    for (std::uint32_t v = 0; v < cluster_of_.size(); ++v) {
      if (cluster_of_[v] == kNone) continue;
      mean[cluster_of_[v]] += within(v);
      members[cluster_of_[v]] += 1;
    }
    chosen_.assign(keys_.size(), kNone);
    std::vector<double> nearest_sq(keys_.size(), std::numeric_limits<double>::infinity());
    for (std::uint32_t v = 0; v < cluster_of_.size(); ++v) {
      const std::uint32_t cluster = cluster_of_[v];
      if (cluster == kNone) continue;
      const double distance_sq = (within(v) - mean[cluster] / members[cluster]).squaredNorm();
      std::uint32_t& chosen = chosen_[cluster];
      const bool higher = chosen == kNone || rank_of(v) > rank_of(chosen);
      if (!higher && (rank_of(v) < rank_of(chosen) || distance_sq >= nearest_sq[cluster])) continue;
      chosen = v;
      nearest_sq[cluster] = distance_sq;
    }
  }

  void add(std::uint32_t t, std::vector<std::uint32_t>& names, Decimated& result) const {
    Corners clusters{}, sources{};
    for (std::size_t i = 0; i < 3; ++i) {
      clusters[i] = cluster_of_[mesh_.triangles[t][i]];
      sources[i] = chosen_[clusters[i]];
    }
    if (is_degenerate(mesh_.positions[sources[0]], mesh_.positions[sources[1]], mesh_.positions[sources[2]])) return;
    Triangle named{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& name = names[clusters[i]];
      if (name == kNone) {
        name = static_cast<std::uint32_t>(result.source.size());
        result.source.push_back(sources[i]);
        result.mesh.positions.push_back(mesh_.positions[sources[i]]);
      }
      named[i] = name;
    }
    result.mesh.triangles.push_back(named);
  }

  const MeshView mesh_;
  const Decimation& wanted_;
  const Vec3 low_;
  const double widest_;
  const Interrupted& interrupted_;
  std::uint64_t cells_ = 1;
  bool stopped_ = false;
  std::vector<std::uint32_t> cluster_of_;  // by vertex; kNone: no triangle uses it
  std::vector<std::uint64_t> keys_;        // by cluster: its cell
  std::vector<std::uint32_t> kept_;        // triangles
  std::vector<std::uint32_t> chosen_;      // by cluster: a vertex
};

// Looks for the finest grid that leaves few enough triangles. Their number grows about as the square of the cells along
// an axis, but not evenly: a bracket is kept, and halved once guessing took too long.
class Search {
 public:
  Search(Clustering& clustering, std::size_t most) : clustering_(clustering), most_(static_cast<double>(most)) {}

  // The cells along an axis; 0: no grid leaves a triangle and not too many, or interrupted.
  std::uint64_t run() {
    std::uint64_t cells = clamped(std::sqrt(most_ / 6));
    for (int grid = 0; grid < kMostGrids; ++grid) {
      const double left = clustering_.make(cells);
      if (clustering_.stopped()) return 0;
      if (left <= most_ && left > best_left_) best_ = cells, best_left_ = left;
      if (best_left_ >= kEnough * most_) break;
      (left > most_ ? high_ : low_) = cells;
      if (high_ - low_ < 2) break;
      cells = next(cells, left, grid);
    }
    return best_;
  }

 private:
  std::uint64_t next(std::uint64_t cells, double left, int grid) const {
    const double guess =
        static_cast<double>(cells) * std::sqrt(kAimedAt * most_ / std::max(left, kAimedAt * most_ / 64));
    const double middle = std::sqrt(static_cast<double>(low_ + 1) * static_cast<double>(high_));
    return clamped(grid < 5 ? guess : middle);
  }

  std::uint64_t clamped(double cells) const {
    const auto whole = static_cast<std::uint64_t>(std::clamp(cells, 1.0, static_cast<double>(kFinest)));
    return std::clamp(whole, low_ + 1, high_ - 1);
  }

  Clustering& clustering_;
  const double most_;
  std::uint64_t low_ = 0;  // leaves too few
  std::uint64_t high_ = kFinest + 1;
  std::uint64_t best_ = 0;
  double best_left_ = 0;
};

}  // namespace

std::optional<Decimated> decimated(MeshView mesh, const Decimation& wanted, const Interrupted& interrupted) {
  if (mesh.triangles.size() <= wanted.max_triangles) return std::nullopt;
  const Box box = bounding_box(mesh, interrupted);
  Clustering clustering(mesh, wanted, box, interrupted);
  if (clustering.widest() > 0) {
    const std::uint64_t cells = Search(clustering, wanted.max_triangles).run();
    if (cells > 0) clustering.make(cells);
    if (clustering.stopped()) return std::nullopt;
    if (cells > 0) {
      Decimated result = clustering.result();
      if (!result.mesh.triangles.empty()) return result;
    }
  }
  if (interrupted()) return std::nullopt;
  return largest_of(mesh, box, wanted.max_triangles);
}

}  // namespace meshgauge
