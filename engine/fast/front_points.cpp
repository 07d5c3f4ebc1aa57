#include "engine/fast/front_points.h"

#include <limits>

namespace meshgauge {
namespace {

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
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(0).squaredNorm();
}

}  // namespace

FrontEnd PointFront::run() {
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

// A corner of each of at most `count` triangles.
std::vector<Vec3> PointFront::sample(MeshView mesh, std::size_t count) const {
  std::vector<Vec3> points;
  points.reserve(count);
  const std::size_t step = mesh.triangles.size() / count + 1;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += step)
    points.push_back(pair_.frame.to_frame(mesh.corner(t, 0)));
  return points;
}

// Whether the meshes seem so far from each other that few points of B bound most of A: A is small against its distance
// from B, or for most of a sample of A one of few points of B is within the distance that some of A has at least.
bool PointFront::seems_far() const {
  const Box of_a = box_of(direction_.from), of_b = box_of(direction_.to);
  const Vec3 centre = (of_a.low + of_a.high) * 0.5;
  const double diagonal = (of_a.high - of_a.low).norm();
  const std::vector<Vec3> of_to = sample(to_, kPoints);
  const auto is_distant = [&](const Vec3& p) { return (p - centre).norm() > kDistant * diagonal; };
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
      return (p - farthest).squaredNorm() < (q - farthest).squaredNorm();
    }));
  }
  const auto within = std::count_if(of_from.begin(), of_from.end(), [&](const Vec3& p) {
    return std::any_of(points.begin(), points.end(), [&](const Vec3& q) { return (p - q).squaredNorm() <= far_sq; });
  });
  return kMostUnmarked * static_cast<std::size_t>(within) >= (kMostUnmarked - 1) * of_from.size();
}

bool PointFront::start() {
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
std::vector<FrontWork::Query> PointFront::farthest_vertices() const {
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
void PointFront::bound_queries(std::vector<Query>& queries, const std::vector<Vec3>& corners) {
  std::vector<double> least_sq(queries.size(), std::numeric_limits<double>::infinity());
  for (const Vec3& p : corners) {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      least_sq[i] = std::min(least_sq[i], (queries[i].point - p).squaredNorm());
    }
  }
  for (std::size_t i = 0; i < queries.size(); ++i) queries[i].upper = std::sqrt(least_sq[i]);
}

// Marks the vertices that are within the limit of points_[first] and those after it. False: interrupted.
bool PointFront::mark(std::size_t first) {
  const double most = limit() - off_, limit_sq = most > 0 ? most * most : 0;
  std::size_t unmarked = 0;
  double marked_sq = marked_sq_;
  const bool done = each_unless(interrupted_, vertices_.size(), [&, frame = pair_.frame](std::uint32_t v) {
    if (any_[v] == kNone) return;
    Vertex vertex = vertices_[v];
    if (first == 0) vertex.least_sq = std::numeric_limits<double>::infinity();
    const Vec3 p = frame.to_frame(from_.positions[v]);
    for (std::size_t k = first; k < points_.size(); ++k) {
      const double sq = (p - points_[k]).squaredNorm();
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
double PointFront::upper_sq(const Triangle& triangle) const {
  const auto& [a, b, c] = triangle;
  if ((vertices_[a].marks & vertices_[b].marks & vertices_[c].marks) != 0) return marked_sq_;
  double least_sq = std::numeric_limits<double>::infinity();
  for (const Vec3& q : points_) {
    least_sq = std::min(
        least_sq, std::max({(point(a) - q).squaredNorm(), (point(b) - q).squaredNorm(), (point(c) - q).squaredNorm()}));
  }
  return least_sq;
}

}  // namespace meshgauge
