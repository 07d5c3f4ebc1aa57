#include "engine/fast/front.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/mesh.h"
#include "engine/mesh/frame.h"
#include "engine/mesh/large_array.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"
#include "engine/tree/nearest.h"
#include "engine/tree/ordered_mesh.h"
#include "engine/tree/vicinity.h"

namespace meshgauge {
namespace {

// What both kinds of fronts share: a lower bound, and leaving out what is within the tolerance of it. One object for
// each direction.
class FrontWork {
 public:
  // The arguments of take_front().
  FrontWork(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, const Slack& slack, double known,
            Control& control, ThreadPool& pool)
      : pair_(pair),
        direction_(direction),
        goal_(goal),
        slack_(slack),
        lower_(known),
        control_(control),
        pool_(pool),
        from_(direction.from.given()),
        to_(direction.to.given()) {}
  FrontWork(const FrontWork&) = delete;
  FrontWork& operator=(const FrontWork&) = delete;

  double lower() const { return lower_; }

 protected:
  ~FrontWork() = default;

  // More than one part of so many of a mesh is not worth the front.
  static constexpr std::size_t kMostLeft = 2;
  static constexpr std::uint32_t kBlock = 64;  // triangles
  // A reach is above the bound that it serves, so that it never decides.
  static constexpr double kWider = 1 + 0x1p-20;

  // A point whose distance from B is wanted.
  struct Query {
    Vec3 point;              // in the frame
    double upper;            // of its distance
    std::uint32_t vertex;    // of A: the point
    std::uint32_t triangle;  // of A: it has the vertex
  };

  // The bound below which triangles are left out, for the lower bound of now.
  double limit() const { return goal_.cull_within_tolerance(lower_, slack_); }

  // Finds the points of B nearest to the queries and raises the lower bound. Adds the largest distance of a found point
  // from B to `off`. `declined`: too much of B is near.
  FrontEnd measure(std::span<const Query> queries, std::vector<Vec3>& nearest_points, double& off) {
    const MeshCells* cells = cells_of_b();
    if (!cells) return FrontEnd::interrupted;
    Vicinity vicinity(*cells);
    for (const Query& query : queries) vicinity.add(Box{query.point, query.point}, kWider * query.upper);
    const auto near = vicinity.triangles(interrupted_);
    if (!near) return FrontEnd::interrupted;
    if (near->empty() || kMostLeft * near->size() > to_.triangles.size()) return FrontEnd::declined;
    const auto part = std::make_unique<NearPart>(direction_.to, *near, pair_.frame, control_, pool_);
    if (!part->complete()) return FrontEnd::interrupted;
    for (const Query& query : queries) {
      std::uint64_t tests = 0;
      const Nearest found = nearest(part->tree, query.point, tests, Nearest::kNone, &interrupted_);
      if (!found.complete) return FrontEnd::interrupted;
      nearest_points.push_back(found.point);
      if (found.distance > lower_) lower_ = found.distance, candidate_ = query.triangle, vertex_ = query.vertex;
    }
    off = std::max(off, part->tree.residual());
    return FrontEnd::taken;
  }

  // Leaves out the triangles t of A with upper_sq(t) within the limit. The search needs the candidate for the witness:
  // of a candidate within the limit it gets the measured vertex alone. `off`: what a bound may be too small by, beside
  // the slack of a distance.
  template <class UpperSq>
  FrontEnd leave_out(const UpperSq& upper_sq, double off) {
    const double most_out = limit() - off, most_out_sq = most_out * most_out;
    if (upper_sq(candidate_) > most_out_sq) vertex_.reset();
    const std::size_t count = from_.triangles.size();
    std::vector<std::uint32_t> rest;
    double left_out_sq = 0, most_sq = 0;
    const auto see = [&](std::uint32_t t, double sq) {
      const bool is_left_out = sq <= most_out_sq && (t != candidate_ || vertex_);
      if (is_left_out) left_out_sq = std::max(left_out_sq, sq);
      if (is_left_out && t != candidate_) return;
      rest.push_back(t);
      most_sq = std::max(most_sq, sq);
    };
    const auto see_block = [&](std::uint32_t block) {  // of most blocks all triangles are left out
      const std::uint32_t begin = block * kBlock;
      const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(begin + kBlock, count));
      std::array<double, kBlock> sq;
      double most = 0;
      for (std::uint32_t t = begin; t < end; ++t) most = std::max(most, sq[t - begin] = upper_sq(t));
      if (most <= most_out_sq && block != candidate_ / kBlock) {
        left_out_sq = std::max(left_out_sq, most);
      } else {
        for (std::uint32_t t = begin; t < end; ++t) see(t, sq[t - begin]);
      }
    };
    const bool done = each_unless(interrupted_, (count + kBlock - 1) / kBlock, see_block, 128);
    if (!done) return FrontEnd::interrupted;
    if (!(most_out > 0) || kMostLeft * rest.size() > from_.triangles.size()) return FrontEnd::declined;
    return keep(rest, std::sqrt(left_out_sq) + off, kWider * std::sqrt(most_sq) + off + rounding::kDistanceSlack);
  }

  Vec3 point(std::uint32_t vertex) const { return pair_.frame.to_frame(from_.positions[vertex]); }
  Box box_of(const MeasuredMesh& mesh) const {
    const Box& box = mesh.prepared.box();
    return {pair_.frame.to_frame(box.low), pair_.frame.to_frame(box.high)};
  }

  const MeasuredPair& pair_;
  MeasuredDirection& direction_;
  const Goal& goal_;
  const Slack slack_;
  double lower_;
  Control& control_;
  ThreadPool& pool_;
  const MeshView from_;
  const MeshView to_;
  const Interrupted interrupted_ = [this] { return control_.check() != Interruption::none; };
  std::uint32_t candidate_ = 0;          // a triangle of A, with the vertex that lower_ is the distance of
  std::optional<std::uint32_t> vertex_;  // that vertex; nullopt: none has raised lower_

 private:
  // Sets what the direction needs to search these triangles of A, whose points have distances of at most `reach`.
  FrontEnd keep(const std::vector<std::uint32_t>& rest, double left_out, double reach) {
    auto kept =
        std::make_unique<OrderedMesh>(from_, rest, direction_.from.prepared.box(), pair_.frame, control_, pool_);
    if (!kept->complete()) return FrontEnd::interrupted;
    const auto first = std::find(kept->original.begin(), kept->original.end(), candidate_) - kept->original.begin();
    if (vertex_) {  // the point that a degenerate triangle spans
      const Triangle& given = from_.triangles[candidate_];
      Triangle& candidate = kept->triangles[static_cast<std::size_t>(first)];
      candidate.fill(
          candidate[static_cast<std::size_t>(std::find(given.begin(), given.end(), *vertex_) - given.begin())]);
    }
    const MeshCells* cells = cells_of_b();
    if (!cells) return FrontEnd::interrupted;
    Vicinity vicinity(*cells);
    for (std::size_t t = 0; t < kept->triangles.size(); ++t) {
      Box box;
      for (int i = 0; i < 3; ++i) box.extend(kept->view().corner(t, i));
      vicinity.add(box, reach);
    }
    const auto near = vicinity.triangles(interrupted_);
    if (!near) return FrontEnd::interrupted;
    if (!near->empty() && kMostLeft * near->size() <= to_.triangles.size()) {
      direction_.near = std::make_unique<NearPart>(direction_.to, *near, pair_.frame, control_, pool_);
      if (!direction_.near->complete()) return FrontEnd::interrupted;
      direction_.reach = reach;
    }
    direction_.first = static_cast<std::uint32_t>(first);
    direction_.left_out = left_out;
    direction_.rest = std::move(kept);
    return FrontEnd::taken;
  }

  // Null: interrupted.
  const MeshCells* cells_of_b() {
    if (!cells_of_b_) cells_of_b_.emplace(to_, box_of(direction_.to), pair_.frame, interrupted_);
    return cells_of_b_->complete() ? &*cells_of_b_ : nullptr;
  }

  std::optional<MeshCells> cells_of_b_;
};

constexpr std::size_t kMovers = 16;  // vertices that are measured: the farthest mover of each part of A
constexpr double kMostMoved = 0.25;  // of B's diagonal: much of B is near a vertex that moves farther
constexpr double kUniform = 0.5;     // mean movement over the largest one from which the meshes seem moved as a whole

// Whether both meshes have the same triangles by index. False also when interrupted.
bool same_indices(MeshView a, MeshView b, const Interrupted& interrupted) {
  if (a.triangles.size() != b.triangles.size()) return false;
  constexpr std::size_t kStep = std::size_t{1} << 16;  // triangles; about 0.1 ms
  for (std::size_t begin = 0; begin < a.triangles.size(); begin += kStep) {
    const std::size_t count = std::min(kStep, a.triangles.size() - begin);
    if (std::memcmp(&a.triangles[begin], &b.triangles[begin], count * sizeof(Triangle)) != 0) return false;
    if (interrupted()) return false;
  }
  return true;
}

// The movements of the vertices from A to B, which bound the triangles of a mesh and of a copy of it that was moved,
// smoothed or deformed. Precondition: same_indices(a, b).
//
// Statement. Let P be a triangle of A with the corners a_i, and T the triangle of B of the same number, with the
// corners b_i. Then h(P,B) <= max |a_i - b_i|.
// Proof. A point of P is a convex combination sum w_i a_i. The point sum w_i b_i lies in T, and their distance
// |sum w_i (a_i - b_i)| is at most max |a_i - b_i|, since norms are convex.
//
// Rounding. The corners are those of the frame. By rounding.h R1 a computed length errs by less than 13u, for which
// kDistanceSlack has room.
class Movement {
 public:
  // Linear time. If it is interrupted, complete() is false and it must not be used.
  Movement(MeshView a, MeshView b, const Frame& frame, const Interrupted& interrupted)
      : sq_(std::min(a.positions.size(), b.positions.size())) {
    double* const sq = sq_.data();  // locals: a store there might change a member
    Vec3 sum = Vec3::Zero();
    bool none = true;
    complete_ = each_unless(interrupted, sq_.size(), [&, frame](std::uint32_t v) {
      const Vec3 &p = a.positions[v], &q = b.positions[v];
      const Vec3 movement = frame.to_frame(q) - frame.to_frame(p);
      sq[v] = squared_norm(movement);
      sum += movement;
      none = none && p == q;
    });
    none_ = none;
    mean_ = sum / static_cast<double>(std::max<std::size_t>(sq_.size(), 1));
  }

  bool complete() const { return complete_; }
  // Whether no vertex moves: the same positions in the meshes' own coordinates, exactly.
  bool none() const { return none_; }
  // The movement of all vertices on average. Not finite if an unused vertex is not.
  const Vec3& mean() const { return mean_; }

  // The square of the largest movement of a corner of this triangle of A. Its root is the bound.
  double upper_sq(const Triangle& triangle) const {
    return std::max(std::max(sq_[triangle[0]], sq_[triangle[1]]), sq_[triangle[2]]);
  }
  // The corner of the triangle that moves farthest.
  std::uint32_t farthest_corner(const Triangle& triangle) const {
    return *std::max_element(triangle.begin(), triangle.end(),
                             [this](std::uint32_t v, std::uint32_t w) { return sq_[v] < sq_[w]; });
  }
  // How far a vertex moves.
  double of(std::uint32_t vertex) const { return std::sqrt(sq_[vertex]); }

 private:
  LargeArray<double> sq_;  // by vertex
  Vec3 mean_ = Vec3::Zero();
  bool none_ = true;
  bool complete_ = false;
};

// The front of meshes with the same triangle indices.
class MovementFront : private FrontWork {
 public:
  using FrontWork::FrontWork;
  using FrontWork::lower;

  FrontEnd run() {
    if (!same_indices(from_, to_, interrupted_)) return FrontEnd::declined;
    const Movement movement(from_, to_, pair_.frame, interrupted_);
    if (!movement.complete()) return FrontEnd::interrupted;
    if (movement.none()) return settle();
    if (!find_movers(movement)) return FrontEnd::interrupted;
    candidate_ = *std::max_element(movers_.begin(), movers_.end(), [&](std::uint32_t s, std::uint32_t t) {
      return movement.upper_sq(from_.triangles[s]) < movement.upper_sq(from_.triangles[t]);
    });
    const double most = std::sqrt(movement.upper_sq(from_.triangles[candidate_]));
    if (!(most > 0)) return FrontEnd::declined;
    if (norm(movement.mean()) > kUniform * most && !raise_by_plane(movement.mean())) return FrontEnd::interrupted;
    if (most > limit()) {
      const FrontEnd end = measure_movers(movement);
      if (end != FrontEnd::taken) return end;
    }
    return leave_out([&](std::uint32_t t) { return movement.upper_sq(from_.triangles[t]); }, 0);
  }

 private:
  FrontEnd settle() {
    const Vec3& point = from_.corner(0, 0);
    direction_.result.bounds = pair_.error.widened({0, 0, Witness{point, 0, point, 0}});
    direction_.result.culling.survivors = 0;
    direction_.settled = true;
    return FrontEnd::taken;
  }

  // Finds the triangle with the farthest mover in each of kMovers parts of A. False: interrupted.
  bool find_movers(const Movement& movement) {
    const std::size_t part = (from_.triangles.size() + kMovers - 1) / kMovers;
    for (std::size_t begin = 0; begin < from_.triangles.size(); begin += part) {
      if (begin > 0 && interrupted_()) return false;
      const auto triangles = from_.triangles.subspan(begin, std::min(part, from_.triangles.size() - begin));
      std::size_t mover = 0;
      double most = -1;
      const bool done = each_unless(interrupted_, triangles.size(), [&](std::uint32_t t) {
        const double upper_sq = movement.upper_sq(triangles[t]);
        if (upper_sq > most) mover = t, most = upper_sq;
      });
      if (!done) return false;
      movers_.push_back(static_cast<std::uint32_t>(begin + mover));
    }
    return true;
  }

  // A copy that is moved as a whole lies before the plane through its rearmost vertex, so that the rearmost vertex of A
  // is at least as far from it as that plane is. False: interrupted.
  bool raise_by_plane(const Vec3& movement) {
    const Vec3 forward = normalized(movement);
    std::uint32_t rearmost = 0;
    double of_a = std::numeric_limits<double>::infinity(), of_b = of_a;
    const auto along = [frame = pair_.frame, forward](const Vec3& p) { return dot(frame.to_frame(p), forward); };
    const auto see_a = [&, positions = from_.positions](std::uint32_t v) {
      const double at = along(positions[v]);
      if (at < of_a) of_a = at, rearmost = v;
    };
    const auto see_b = [&, positions = to_.positions](std::uint32_t v) { of_b = std::min(of_b, along(positions[v])); };
    if (!each_unless(interrupted_, from_.positions.size(), see_a)) return false;
    if (!each_unless(interrupted_, to_.positions.size(), see_b)) return false;
    if (!(of_b - of_a > lower_)) return true;
    std::optional<std::uint32_t> user;  // a triangle
    const bool done =
        each_unless(interrupted_, from_.triangles.size(), [&, triangles = from_.triangles](std::uint32_t t) {
          const auto& [a, b, c] = triangles[t];
          if ((a == rearmost) | (b == rearmost) | (c == rearmost)) user = t;
        });
    if (done && user) lower_ = of_b - of_a, candidate_ = *user, vertex_ = rearmost;
    return done;
  }

  // Raises the lower bound to the largest distance of the movers from B.
  FrontEnd measure_movers(const Movement& movement) {
    const Box box = box_of(direction_.to);
    const double diagonal = norm(box.high - box.low);
    std::vector<Query> queries;
    for (const std::uint32_t t : movers_) {
      const std::uint32_t v = movement.farthest_corner(from_.triangles[t]);
      if (movement.of(v) > kMostMoved * diagonal) return FrontEnd::declined;
      if (movement.of(v) > limit()) queries.push_back({point(v), movement.of(v), v, t});
    }
    std::vector<Vec3> nearest_points;
    double off = 0;
    return measure(queries, nearest_points, off);
  }

  std::vector<std::uint32_t> movers_;  // triangles of A
};

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kSample = 64;  // vertices of A that decide whether to try
constexpr double kDistant = 2;       // diagonals of A
constexpr std::size_t kMorePoints = 2048;
constexpr std::size_t kPoints = 64;     // points of B that decide whether to try
constexpr std::size_t kCorners = 1024;  // of B, that bound a distance from it
constexpr std::size_t kQueries = 2;     // vertices measured in one round: the farthest one of each part of A
constexpr std::size_t kRounds = 3;
constexpr std::size_t kMostUnmarked = 4;  // more than one vertex of so many without a mark: declined
constexpr double kFarForDetail = 0x1p-4;  // of A's diagonal

double distance_sq(const Box& box, const Vec3& p) {
  return squared_norm((box.low - p).cwiseMax(p - box.high).cwiseMax(0));
}

// The front of meshes that are far from each other: single points of B bound triangles of A.
//
// Statement. Let b be a point of B and P a triangle of A. Then h(P,B) <= max over corners c of P of |c - b|.
// Proof. |. - b| is convex, so its maximum over P is at a corner; and d(x,B) <= |x - b|.
//
// Rounding. b is a computed nearest point, within 38u + residual of B (rounding.h R2), and the length errs by 13u (R1):
// kDistanceSlack has room for all but the residual of b's triangle, which is added.
//
// Where h(A,B) is large against the meshes' detail, the nearest points of a few vertices bound most triangles. The
// vertices are the farthest ones from B: first from its box, then from the points that were found.
class PointFront : private FrontWork {
 public:
  using FrontWork::FrontWork;
  using FrontWork::lower;

  FrontEnd run() {
    if (!seems_far()) return FrontEnd::declined;
    if (!start()) return FrontEnd::interrupted;
    const std::vector<Vec3> corners = sample(to_, kCorners);
    for (std::size_t round = 0; round < kRounds && unmarked_ > 0; ++round) {
      std::vector<Query> queries = farthest_vertices();
      bound_queries(queries, corners);
      const std::size_t known = points_.size();
      if (const FrontEnd end = measure(queries, points_, off_); end != FrontEnd::taken) return end;
      if (!mark(known)) return FrontEnd::interrupted;
      if (kMostUnmarked * unmarked_ > vertices_.size()) return FrontEnd::declined;
    }
    return leave_out([this](std::uint32_t t) { return upper_sq(from_.triangles[t]); }, off_);
  }

 private:
  // A vertex of A.
  struct Vertex {
    double least_sq;      // the squared distance from the nearest of points_; before the first one, from B's box
    std::uint32_t marks;  // bit k: points_[k] is within the limit
  };

  // A corner of each of at most `count` triangles.
  std::vector<Vec3> sample(MeshView mesh, std::size_t count) const {
    std::vector<Vec3> points;
    points.reserve(count);
    const std::size_t step = mesh.triangles.size() / count + 1;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += step)
      points.push_back(pair_.frame.to_frame(mesh.corner(t, 0)));
    return points;
  }

  // Whether the meshes seem so far from each other that few points of B bound most of A: A is small against its
  // distance from B, or for most of a sample of A one of few points of B is within the distance that some of A has at
  // least.
  bool seems_far() const {
    const Box of_a = box_of(direction_.from), of_b = box_of(direction_.to);
    const Vec3 centre = (of_a.low + of_a.high) * 0.5;
    const double diagonal = norm(of_a.high - of_a.low);
    const std::vector<Vec3> of_to = sample(to_, kPoints);
    const auto is_distant = [&](const Vec3& p) { return norm(p - centre) > kDistant * diagonal; };
    if (std::all_of(of_to.begin(), of_to.end(), is_distant)) {
      const std::vector<Vec3> more = sample(to_, kMorePoints);
      if (std::all_of(more.begin(), more.end(), is_distant)) return true;
    }
    const std::vector<Vec3> of_from = sample(from_, kSample);
    double far_sq = lower_ * lower_;
    for (const Vec3& p : of_from) far_sq = std::max(far_sq, distance_sq(of_b, p));
    if (!(std::sqrt(far_sq) > kFarForDetail * diagonal)) return false;
    std::vector<Vec3> points;  // as the first round of run() may find them
    const std::size_t part = of_from.size() / kQueries + 1;
    for (std::size_t begin = 0; begin < of_from.size(); begin += part) {
      const auto first = of_from.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = first + static_cast<std::ptrdiff_t>(std::min(part, of_from.size() - begin));
      const auto from_box = [&](const Vec3& p, const Vec3& q) { return distance_sq(of_b, p) < distance_sq(of_b, q); };
      const Vec3& farthest = *std::max_element(first, last, from_box);
      points.push_back(*std::min_element(of_to.begin(), of_to.end(), [&](const Vec3& p, const Vec3& q) {
        return squared_norm(p - farthest) < squared_norm(q - farthest);
      }));
    }
    const auto within = std::count_if(of_from.begin(), of_from.end(), [&](const Vec3& p) {
      return std::any_of(points.begin(), points.end(), [&](const Vec3& q) { return squared_norm(p - q) <= far_sq; });
    });
    return kMostUnmarked * static_cast<std::size_t>(within) >= (kMostUnmarked - 1) * of_from.size();
  }

  bool start() {
    any_.assign(from_.positions.size(), kNone);
    const auto use = [triangles = from_.triangles, any = any_.data()](std::uint32_t t) {
      for (const std::uint32_t v : triangles[t]) any[v] = t;
    };
    const bool done = each_unless(interrupted_, from_.triangles.size(), use);
    const Box box = box_of(direction_.to);
    vertices_.resize(any_.size());
    return done && each_unless(interrupted_, vertices_.size(), [&](std::uint32_t v) {
             if (any_[v] == kNone) return;
             vertices_[v] = {distance_sq(box, point(v)), 0};
             ++unmarked_;
           });
  }

  // Returns of each of kQueries parts of A's vertices the one without a mark that is farthest from the points, or from
  // B's box.
  std::vector<Query> farthest_vertices() const {
    std::vector<Query> queries;
    const std::size_t part = vertices_.size() / kQueries + 1;
    for (std::size_t begin = 0; begin < vertices_.size(); begin += part) {
      std::size_t farthest = kNone;
      double most_sq = -1;
      for (std::size_t v = begin; v < std::min(begin + part, vertices_.size()); ++v) {
        if (any_[v] == kNone || vertices_[v].marks != 0 || vertices_[v].least_sq <= most_sq) continue;
        farthest = v, most_sq = vertices_[v].least_sq;
      }
      if (farthest == kNone) continue;
      const auto v = static_cast<std::uint32_t>(farthest);
      queries.push_back({point(v), std::numeric_limits<double>::infinity(), v, any_[v]});
    }
    return queries;
  }

  // Bounds the distances of the queries by those of these corners of B.
  static void bound_queries(std::vector<Query>& queries, const std::vector<Vec3>& corners) {
    std::vector<double> least_sq(queries.size(), std::numeric_limits<double>::infinity());
    for (const Vec3& p : corners) {
      for (std::size_t i = 0; i < queries.size(); ++i) {
        least_sq[i] = std::min(least_sq[i], squared_norm(queries[i].point - p));
      }
    }
    for (std::size_t i = 0; i < queries.size(); ++i) queries[i].upper = std::sqrt(least_sq[i]);
  }

  // Marks the vertices that are within the limit of points_[first] and those after it. False: interrupted.
  bool mark(std::size_t first) {
    const double most = limit() - off_, limit_sq = most > 0 ? most * most : 0;
    std::size_t unmarked = 0;
    double marked_sq = marked_sq_;
    const bool done = each_unless(interrupted_, vertices_.size(), [&, frame = pair_.frame](std::uint32_t v) {
      if (any_[v] == kNone) return;
      Vertex vertex = vertices_[v];
      if (first == 0) vertex.least_sq = std::numeric_limits<double>::infinity();
      const Vec3 p = frame.to_frame(from_.positions[v]);
      for (std::size_t k = first; k < points_.size(); ++k) {
        const double sq = squared_norm(p - points_[k]);
        vertex.least_sq = std::min(vertex.least_sq, sq);
        if (sq > limit_sq) continue;
        vertex.marks |= std::uint32_t{1} << k;
        marked_sq = std::max(marked_sq, sq);
      }
      if (vertex.marks == 0) ++unmarked;
      vertices_[v] = vertex;
    });
    unmarked_ = unmarked;
    marked_sq_ = marked_sq;
    return done;
  }

  // The bound's square, or for triangles with a common mark that of all of them.
  double upper_sq(const Triangle& triangle) const {
    const auto& [a, b, c] = triangle;
    if ((vertices_[a].marks & vertices_[b].marks & vertices_[c].marks) != 0) return marked_sq_;
    double least_sq = std::numeric_limits<double>::infinity();
    for (const Vec3& q : points_) {
      least_sq = std::min(
          least_sq, std::max({squared_norm(point(a) - q), squared_norm(point(b) - q), squared_norm(point(c) - q)}));
    }
    return least_sq;
  }

  std::vector<Vec3> points_;  // of B
  LargeArray<Vertex> vertices_;
  std::vector<std::uint32_t> any_;  // by vertex of A: a triangle that uses it, or kNone
  double off_ = 0;                  // the largest distance of points_ from B that kDistanceSlack has no room for
  std::size_t unmarked_ = 0;        // used vertices without a mark
  double marked_sq_ = 0;            // the largest squared distance that has a mark
};

}  // namespace

FrontEnd take_front(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, Slack slack,
                    double& known, Control& control, ThreadPool& pool) {
  slack.residual = rounding::kUsualResidual;
  const auto run = [&]<class Front>(std::type_identity<Front>) {
    Front front(pair, direction, goal, slack, known, control, pool);
    const FrontEnd end = front.run();
    if (end == FrontEnd::taken) known = front.lower();
    return end;
  };
  const FrontEnd end = run(std::type_identity<MovementFront>());
  return end == FrontEnd::declined ? run(std::type_identity<PointFront>()) : end;
}

}  // namespace meshgauge
