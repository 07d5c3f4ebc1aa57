#include "oracle/farthest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace meshgauge::oracle {
namespace {

using Flat = std::array<Vec3, 3>;

// Both surfaces relative to a corner of the first and scaled to about unit size. They are rounded, which is enough for
// proposals.
class Frame {
 public:
  Frame(const Surface& from, const Surface& to) : origin_(from.front()[0]) {
    bool is_point = true;
    for (const Surface* surface : {&from, &to}) {
      for (const Corners& t : *surface) {
        for (const Point& p : t) {
          const Point q = p - origin_;
          for (const Dyadic* x : {&q.x, &q.y, &q.z}) {
            if (x->sign() == 0) continue;
            exponent_ = is_point ? x->magnitude() : std::max(exponent_, x->magnitude());
            is_point = false;
          }
        }
      }
    }
  }

  std::vector<Flat> flatten(const Surface& surface) const {
    std::vector<Flat> flat;
    flat.reserve(surface.size());
    for (const Corners& t : surface) flat.push_back({flatten(t[0]), flatten(t[1]), flatten(t[2])});
    return flat;
  }

 private:
  Vec3 flatten(const Point& p) const {
    const Point q = p - origin_;
    return {q.x.approximate(-exponent_), q.y.approximate(-exponent_), q.z.approximate(-exponent_)};
  }

  Point origin_;
  long exponent_ = 0;
};

double to_segment_sq(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a, ap = p - a;
  const double length_sq = ab.squaredNorm();
  const double t = length_sq > 0 ? std::clamp(ap.dot(ab) / length_sq, 0.0, 1.0) : 0.0;
  return (ap - t * ab).squaredNorm();
}

double to_triangle_sq(const Vec3& p, const Flat& t) {
  const auto& [a, b, c] = t;
  const Vec3 n = (b - a).cross(c - a);
  const double n_sq = n.squaredNorm();
  const auto left = [&](const Vec3& from, const Vec3& to) { return (to - from).cross(p - from).dot(n) >= 0; };
  if (n_sq > 0 && left(a, b) && left(b, c) && left(c, a)) {
    const double height = (p - a).dot(n);
    return height * height / n_sq;
  }
  return std::min({to_segment_sq(p, a, b), to_segment_sq(p, b, c), to_segment_sq(p, c, a)});
}

struct Part {
  std::array<std::size_t, 3> corners;  // measured points
  std::size_t triangle = 0;
  double upper = 0;
  bool operator<(const Part& other) const { return upper < other.upper; }
};

class Proposer {
 public:
  Proposer(const Surface& from, const Surface& to) {
    const Frame frame(from, to);
    from_ = frame.flatten(from);
    to_ = frame.flatten(to);
  }

  void search(std::size_t max_points) {
    for (std::size_t t = 0; t < from_.size(); ++t) {
      add({measure(t, {1, 0}), measure(t, {0, 1}), measure(t, {0, 0})}, t);
      measure(t, {0.25, 0.25});
    }
    while (!heap_.empty() && nearest_.size() < max_points) {
      std::pop_heap(heap_.begin(), heap_.end());
      const Part piece = heap_.back();
      heap_.pop_back();
      if (piece.upper > best_) bisect(piece);
    }
  }

  // The best point of each of the best few pieces of surface, improved by a climb, and some more points.
  std::vector<Proposal> proposals() {
    std::vector<std::size_t> order(points_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    const std::size_t count = std::min<std::size_t>(kKept, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                      [&](std::size_t i, std::size_t j) { return nearest_[i] > nearest_[j]; });
    order.resize(count);
    std::vector<Proposal> best;
    best.reserve(count + kClimbs);
    for (const std::size_t i : order) best.push_back(points_[i]);
    for (std::size_t i = 0; i < std::min<std::size_t>(kClimbs, count); ++i) best.push_back(climb(best[i]));
    return best;
  }

 private:
  static constexpr std::size_t kKept = 6;
  static constexpr std::size_t kClimbs = 2;

  Vec3 position(std::size_t triangle, const Weights& w) const {
    const Flat& t = from_[triangle];
    return w.first * t[0] + w.second * t[1] + (1 - w.first - w.second) * t[2];
  }

  std::size_t measure(std::size_t triangle, const Weights& weights) {
    const Vec3 p = position(triangle, weights);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Flat& t : to_) {
      distances_.push_back(to_triangle_sq(p, t));
      nearest = std::min(nearest, distances_.back());
    }
    points_.push_back({triangle, weights});
    positions_.push_back(p);
    nearest_.push_back(nearest);
    best_ = std::max(best_, nearest);
    return points_.size() - 1;
  }

  void add(const std::array<std::size_t, 3>& corners, std::size_t triangle) {
    Part piece{corners, triangle, std::numeric_limits<double>::infinity()};
    for (std::size_t t = 0; t < to_.size(); ++t) {
      double worst = 0;
      for (const std::size_t corner : corners) worst = std::max(worst, distances_[corner * to_.size() + t]);
      piece.upper = std::min(piece.upper, worst);
    }
    if (piece.upper <= best_) return;
    heap_.push_back(piece);
    std::push_heap(heap_.begin(), heap_.end());
  }

  void bisect(const Part& piece) {
    std::size_t edge = 0;
    double longest = -1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = (positions_[piece.corners[i]] - positions_[piece.corners[(i + 1) % 3]]).squaredNorm();
      if (length > longest) longest = length, edge = i;
    }
    const std::size_t a = piece.corners[edge], b = piece.corners[(edge + 1) % 3], c = piece.corners[(edge + 2) % 3];
    const Weights &wa = points_[a].weights, &wb = points_[b].weights;
    const std::size_t m = measure(piece.triangle, {(wa.first + wb.first) / 2, (wa.second + wb.second) / 2});
    add({a, m, c}, piece.triangle);
    add({m, b, c}, piece.triangle);
  }

  // A pattern search over the triangle: steps in six directions, halved when none increases the distance.
  Proposal climb(Proposal at) {
    static constexpr std::array<Weights, 6> kDirections{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}}};
    double height = height_of(at);
    double step = 0x1p-4;
    for (int budget = 400; budget > 0 && step > 0x1p-52;) {
      bool rose = false;
      for (const Weights& d : kDirections) {
        --budget;
        const Proposal next{at.triangle, {at.weights.first + step * d.first, at.weights.second + step * d.second}};
        if (next.weights.first < 0 || next.weights.second < 0 || next.weights.first + next.weights.second > 1) continue;
        const double there = height_of(next);
        if (there <= height) continue;
        at = next, height = there, rose = true;
        break;
      }
      if (!rose) step /= 2;
    }
    return at;
  }

  double height_of(const Proposal& proposal) const {
    const Vec3 p = position(proposal.triangle, proposal.weights);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Flat& t : to_) nearest = std::min(nearest, to_triangle_sq(p, t));
    return nearest;
  }

  std::vector<Flat> from_, to_;
  std::vector<Proposal> points_;
  std::vector<Vec3> positions_;
  std::vector<double> distances_;  // squared, of point i to triangle t at i * |to| + t
  std::vector<double> nearest_;    // squared
  double best_ = 0;
  std::vector<Part> heap_;
};

}  // namespace

std::vector<Proposal> propose_farthest(const Surface& from, const Surface& to, std::size_t max_points) {
  Proposer proposer(from, to);
  proposer.search(max_points);
  return proposer.proposals();
}

Farthest farthest_sample(const Surface& from, const Surface& to, std::size_t max_points) {
  Farthest best{{}, distance_sq(from.front()[0], to)};
  for (const Proposal& proposal : propose_farthest(from, to, max_points)) {
    if (!are_inside(proposal.weights)) continue;
    const Ratio d_sq = distance_sq(point_at(from[proposal.triangle], proposal.weights), to);
    if (d_sq > best.distance_sq) best = {proposal, d_sq};
  }
  return best;
}

}  // namespace meshgauge::oracle
