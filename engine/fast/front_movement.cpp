#include "engine/fast/front_movement.h"

#include <limits>

namespace meshgauge {
namespace {

constexpr std::size_t kMovers = 16;  // vertices that are measured: the farthest mover of each part of A
constexpr double kMostMoved = 0.25;  // of B's diagonal: much of B is near a vertex that moves farther
constexpr double kUniform = 0.5;     // mean movement over the largest one from which the meshes seem moved as a whole

}  // namespace

FrontEnd MovementFront::run() {
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
  if (movement.mean().norm() > kUniform * most && !raise_by_plane(movement.mean())) return FrontEnd::interrupted;
  if (most > limit()) {
    const FrontEnd end = measure_movers(movement);
    if (end != FrontEnd::taken) return end;
  }
  return leave_out([&](std::uint32_t t) { return movement.upper_sq(from_.triangles[t]); }, 0);
}

FrontEnd MovementFront::settle() {
  const Vec3& point = from_.corner(0, 0);
  direction_.result.bounds = pair_.error.widened({0, 0, Witness{point, 0, point, 0}});
  direction_.result.culling.survivors = 0;
  direction_.settled = true;
  return FrontEnd::taken;
}

// Finds the triangle with the farthest mover in each of kMovers parts of A. False: interrupted.
bool MovementFront::find_movers(const Movement& movement) {
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
bool MovementFront::raise_by_plane(const Vec3& movement) {
  const Vec3 forward = movement.normalized();
  std::uint32_t rearmost = 0;
  double of_a = std::numeric_limits<double>::infinity(), of_b = of_a;
  const auto along = [frame = pair_.frame, forward](const Vec3& p) { return frame.to_frame(p).dot(forward); };
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
FrontEnd MovementFront::measure_movers(const Movement& movement) {
  const Box box = box_of(direction_.to);
  const double diagonal = (box.high - box.low).norm();
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

}  // namespace meshgauge
