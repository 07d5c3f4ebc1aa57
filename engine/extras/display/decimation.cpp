#include "engine/extras/display/decimation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/mesh/index_table.h"

namespace meshgauge {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::uint64_t kFinest = std::uint64_t{1} << 20;  // cells along the widest axis: three fit into a word
constexpr std::size_t kBlock = std::size_t{1} << 16;       // elements between two checks of the clock
constexpr int kMostGrids = 14;
constexpr double kEnough = 0.7;  // of max_triangles: no further grid is tried
constexpr double kAimedAt = 0.85;

using Corners = std::array<std::uint32_t, 3>;

bool is_smaller(const std::pair<double, std::uint32_t>& a, const std::pair<double, std::uint32_t>& b) {
  return a.first != b.first ? a.first > b.first : a.second < b.second;
}

// Collects triangles over the vertices of a mesh, with those vertices that they use.
class Collected {
 public:
  explicit Collected(MeshView mesh) : mesh_(mesh), names_(mesh.positions.size(), kNone) {}

  bool has(std::uint32_t vertex) const { return names_[vertex] != kNone; }
  std::size_t triangles() const { return made_.mesh.triangles.size(); }

  void add(const Triangle& triangle) {
    Triangle named{};
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& name = names_[triangle[i]];
      if (name == kNone) {
        name = static_cast<std::uint32_t>(made_.source.size());
        made_.source.push_back(triangle[i]);
        made_.mesh.positions.push_back(mesh_.positions[triangle[i]]);
      }
      named[i] = name;
    }
    made_.mesh.triangles.push_back(named);
  }

  Decimated take() { return std::move(made_); }

 private:
  const MeshView mesh_;
  std::vector<std::uint32_t> names_;  // by vertex of the mesh: its number in the result
  Decimated made_;
};

// The visible size of a triangle: twice its area, relative to the square of the box's widest side.
class Sizes {
 public:
  Sizes(MeshView mesh, const Box& box) : mesh_(mesh), low_(box.low), widest_((box.high - box.low).maxCoeff()) {}

  double operator()(std::uint32_t t) const {
    if (widest_ == 0) return 0;
    const Vec3 e = scaled(t, 1) - scaled(t, 0), f = scaled(t, 2) - scaled(t, 0);
    const Vec3 cross(e.y() * f.z() - e.z() * f.y(), e.z() * f.x() - e.x() * f.z(), e.x() * f.y() - e.y() * f.x());
    return norm(cross);
  }

  // Whether a is larger than b. A triangle with area is larger than one without, regardless of rounding.
  bool is_larger(std::uint32_t a, std::uint32_t b) const {
    const bool flat_a = is_flat(a), flat_b = is_flat(b);
    return flat_a != flat_b ? flat_b : (*this)(a) > (*this)(b);
  }

  bool is_flat(std::uint32_t t) const {
    return is_degenerate(mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2));
  }

 private:
  Vec3 scaled(std::uint32_t t, int i) const { return (mesh_.corner(t, i) - low_) / widest_; }

  const MeshView mesh_;
  const Vec3 low_;
  const double widest_;
};

// A selection of unchanged triangles: for each vertex with a rank one that uses it, the highest ranks first, on up to
// half of max_triangles; then the largest triangles.
class AsTheyAre {
 public:
  AsTheyAre(MeshView mesh, const Decimation& wanted, const Box& box)
      : mesh_(mesh), wanted_(wanted), sizes_(mesh, box), made_(mesh), taken_(mesh.triangles.size(), false) {}

  Decimated result() {
    const std::size_t most = std::min(wanted_.max_triangles, mesh_.triangles.size());
    if (!wanted_.rank.empty()) add_ranked(std::max<std::size_t>(most / 2, 1));
    std::vector<std::pair<double, std::uint32_t>> order(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < order.size(); ++t) order[t] = {sizes_(t), t};
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(most);
    std::partial_sort(order.begin(), end, order.end(), is_smaller);
    for (auto at = order.begin(); at != end && made_.triangles() < most; ++at) {
      if (!taken_[at->second] && (made_.triangles() == 0 || !sizes_.is_flat(at->second)))
        made_.add(triangle(at->second));
    }
    return made_.take();
  }

 private:
  const Triangle& triangle(std::uint32_t t) const { return mesh_.triangles[t]; }

  std::uint8_t rank_of(std::uint32_t t) const {
    const Triangle& c = triangle(t);
    return std::max({wanted_.rank[c[0]], wanted_.rank[c[1]], wanted_.rank[c[2]]});
  }

  void add_ranked(std::size_t most) {
    std::vector<std::uint32_t> ranked;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (rank_of(t) > 0) ranked.push_back(t);
    }
    std::sort(ranked.begin(), ranked.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (rank_of(a) != rank_of(b)) return rank_of(a) > rank_of(b);
      return sizes_.is_larger(a, b) || (!sizes_.is_larger(b, a) && a < b);
    });
    for (const std::uint32_t t : ranked) {
      if (made_.triangles() == most) return;
      const auto is_new = [&](std::uint32_t vertex) { return wanted_.rank[vertex] > 0 && !made_.has(vertex); };
      if (std::none_of(triangle(t).begin(), triangle(t).end(), is_new)) continue;
      made_.add(triangle(t));
      taken_[t] = true;
    }
  }

  const MeshView mesh_;
  const Decimation& wanted_;
  const Sizes sizes_;
  Collected made_;
  std::vector<bool> taken_;  // by triangle
};

class Clustering {
 public:
  Clustering(MeshView mesh, const Decimation& wanted, const Box& box, const Interrupted& interrupted)
      : mesh_(mesh),
        wanted_(wanted),
        low_(box.low),
        widest_((box.high - box.low).maxCoeff()),
        sizes_(mesh, box),
        interrupted_(interrupted),
        cluster_of_(mesh.positions.size(), kNone) {}

  // Makes the clusters of a grid with `cells` along the widest axis. Returns how many triangles they leave: an estimate
  // if it is more than max_triangles; 0 if interrupted.
  double make(std::uint64_t cells) {
    cells_ = cells;
    return assign_clusters() ? collect_triangles() : 0;
  }

  bool stopped() const { return stopped_; }
  double widest() const { return widest_; }

  // Selects the triangles that stay with the clusters made last, and returns how many more are needed so that every
  // cluster with a ranked vertex has one. Precondition: make() returned at most max_triangles.
  std::size_t settle() {
    choose();
    std::erase_if(kept_, [&](std::uint32_t t) { return is_flat(t); });
    std::vector<bool> shown(keys_.size(), false);
    for (const std::uint32_t t : kept_) {
      for (const std::uint32_t vertex : mesh_.triangles[t]) shown[cluster_of_[vertex]] = true;
    }
    lost_.clear();
    for (std::uint32_t c = 0; c < shown.size(); ++c) {
      if (!shown[c] && rank_of(chosen_[c]) > 0) lost_.push_back(c);
    }
    std::stable_sort(lost_.begin(), lost_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return rank_of(chosen_[a]) > rank_of(chosen_[b]); });
    return lost_.size();
  }

  std::size_t kept() const { return kept_.size(); }

  // After settle(): returns the triangles that stay and, for each cluster that would be lost, one of its own, the
  // highest ranks first, as many as fit.
  Decimated result() const {
    Collected made(mesh_);
    for (const std::uint32_t t : kept_) made.add(chosen_of(t));
    const std::vector<std::uint32_t> own = own_triangles();
    for (const std::uint32_t cluster : lost_) {
      if (made.triangles() == wanted_.max_triangles) break;
      if (!made.has(chosen_[cluster])) made.add(mesh_.triangles[own[cluster]]);
    }
    return made.take();
  }

 private:
  bool interrupted() { return stopped_ = stopped_ || interrupted_(); }

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
      if (t % kBlock == 0 && interrupted()) return false;
      for (const std::uint32_t vertex : mesh_.triangles[t]) {
        if (cluster_of_[vertex] == kNone) cluster_of_[vertex] = cluster_at(key_of(vertex), table);
      }
    }
    return true;
  }

  std::uint32_t cluster_at(std::uint64_t key, IndexTable& table) {
    const auto next = static_cast<std::uint32_t>(keys_.size());
    const std::uint32_t found =
        table.find_or_store(mix(key ^ hash_seed.value), next, [&](std::uint32_t other) { return keys_[other] == key; });
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
      if (t % kBlock == 0 && interrupted()) return 0;
      const Corners c = corners_of(t);
      if (c[0] == c[1] || c[1] == c[2]) continue;
      const std::uint64_t hash = mix(mix(hash_seed.value ^ (std::uint64_t{c[0]} << 32 | c[1])) ^ c[2]);
      if (table.find_or_store(hash, t, [&](std::uint32_t o) { return corners_of(o) == c; }) != IndexTable::kNone) {
        continue;
      }
      kept_.push_back(t);
      // The table is full: estimates the number for all triangles from the share seen.
      if (kept_.size() > wanted_.max_triangles) {
        return std::max(static_cast<double>(kept_.size()),
                        static_cast<double>(kept_.size()) * (static_cast<double>(all) / static_cast<double>(t + 1)));
      }
    }
    return static_cast<double>(kept_.size());
  }

  std::uint8_t rank_of(std::uint32_t vertex) const { return wanted_.rank.empty() ? 0 : wanted_.rank[vertex]; }

  // Chooses for each cluster the vertex that stands for it.
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
      const double distance_sq = squared_norm(within(v) - mean[cluster] / members[cluster]);
      std::uint32_t& chosen = chosen_[cluster];
      const bool higher = chosen == kNone || rank_of(v) > rank_of(chosen);
      if (!higher && (rank_of(v) < rank_of(chosen) || distance_sq >= nearest_sq[cluster])) continue;
      chosen = v;
      nearest_sq[cluster] = distance_sq;
    }
  }

  Triangle chosen_of(std::uint32_t t) const {
    Triangle chosen{};
    for (std::size_t i = 0; i < 3; ++i) chosen[i] = chosen_[cluster_of_[mesh_.triangles[t][i]]];
    return chosen;
  }

  bool is_flat(std::uint32_t t) const {
    const Triangle c = chosen_of(t);
    return is_degenerate(mesh_.positions[c[0]], mesh_.positions[c[1]], mesh_.positions[c[2]]);
  }

  // By cluster, for those that are lost: the largest triangle at the chosen vertex.
  std::vector<std::uint32_t> own_triangles() const {
    std::vector<std::uint32_t> own(keys_.size(), kNone);
    if (lost_.empty()) return own;
    std::vector<bool> lost(keys_.size(), false);
    for (const std::uint32_t cluster : lost_) lost[cluster] = true;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const std::uint32_t vertex : mesh_.triangles[t]) {
        const std::uint32_t cluster = cluster_of_[vertex];
        if (!lost[cluster] || chosen_[cluster] != vertex) continue;
        if (own[cluster] == kNone || sizes_.is_larger(t, own[cluster])) own[cluster] = t;
      }
    }
    return own;
  }

  const MeshView mesh_;
  const Decimation& wanted_;
  const Vec3 low_;
  const double widest_;
  const Sizes sizes_;
  const Interrupted& interrupted_;
  std::uint64_t cells_ = 1;
  bool stopped_ = false;
  std::vector<std::uint32_t> cluster_of_;  // by vertex; kNone: no triangle uses it
  std::vector<std::uint64_t> keys_;        // by cluster: its cell
  std::vector<std::uint32_t> kept_;        // triangles
  std::vector<std::uint32_t> chosen_;      // by cluster: a vertex
  std::vector<std::uint32_t> lost_;        // clusters with a ranked vertex but no kept triangle
};

// Searches the finest grid that leaves few enough triangles. Their number grows about as the square of the cells along
// an axis, but not evenly: it keeps a bracket, and bisects it after five guesses.
class Search {
 public:
  Search(Clustering& clustering, std::size_t most) : clustering_(clustering), most_(static_cast<double>(most)) {}

  // Returns the cells along an axis. 0: no grid that leaves few enough triangles leaves any, or interrupted.
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

// Returns the mesh of the finest grid that fits, or of a coarser one if that makes room for the lost clusters. nullopt:
// no grid leaves a triangle, or interrupted.
std::optional<Decimated> clustered(Clustering& clustering, std::size_t most) {
  for (std::size_t left_to_grid = most;;) {
    const std::uint64_t cells = Search(clustering, left_to_grid).run();
    if (cells == 0) return std::nullopt;
    clustering.make(cells);
    if (clustering.stopped()) return std::nullopt;
    const std::size_t lost = clustering.settle();
    if (clustering.kept() == 0) return std::nullopt;
    if (left_to_grid < most || lost <= most - clustering.kept()) return clustering.result();
    left_to_grid = most - std::max<std::size_t>(1, std::min(2 * lost, most / 4));
  }
}

}  // namespace

std::optional<Decimated> decimated(MeshView mesh, const Decimation& wanted, const Interrupted& interrupted) {
  if (mesh.triangles.size() <= wanted.max_triangles) return std::nullopt;
  const Box box = bounding_box(mesh, interrupted);
  Clustering clustering(mesh, wanted, box, interrupted);
  if (clustering.widest() > 0) {
    auto result = clustered(clustering, wanted.max_triangles);
    if (clustering.stopped()) return std::nullopt;
    if (result) return result;
  }
  if (interrupted()) return std::nullopt;
  return AsTheyAre(mesh, wanted, box).result();
}

}  // namespace meshgauge
