#include "engine/front.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "engine/bounds/movement.h"
#include "engine/nearest.h"
#include "engine/rounding.h"
#include "engine/vicinity.h"

namespace meshgauge {
namespace {

constexpr std::size_t kMovers = 16;     // vertices that are measured: the farthest mover of each part of A
constexpr std::size_t kMostLeft = 2;    // more than this part of a mesh is not worth the front
constexpr double kUniform = 0.5;        // mean movement over the largest one from which the meshes seem moved
constexpr double kWider = 1 + 0x1p-20;  // a reach is above the bound that it serves, so that it never decides

// By movement. One object for each direction.
class MovementFront {
 public:
  MovementFront(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, const Slack& slack,
                double known, Control& control, ThreadPool& pool)
      : pair_(pair),
        direction_(direction),
        goal_(goal),
        slack_(slack),
        lower_(known),
        control_(control),
        pool_(pool),
        from_(direction.from.given()),
        to_(direction.to.given()) {}

  double lower() const { return lower_; }

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
    if (movement.mean().norm() > kUniform * most && !raise_by_plane(movement.mean())) return FrontEnd::interrupted;
    if (most > limit()) {
      const FrontEnd end = measure_movers(movement);
      if (end != FrontEnd::taken) return end;
    }
    return leave_out(movement);
  }

 private:
  double limit() const { return goal_.cull_within_tolerance(lower_, slack_); }

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
    double most = 0;
    return each_unless(interrupted_, from_.triangles.size(), [&](std::uint32_t t) {
      const double upper_sq = movement.upper_sq(from_.triangles[t]);
      if (t % part == 0) movers_.push_back(t), most = upper_sq;
      if (upper_sq > most) movers_.back() = t, most = upper_sq;
    });
  }

  // A copy that is moved as a whole lies before the plane through its rearmost vertex, so that the rearmost vertex of A
  // is at least as far from it as that plane is. False: interrupted.
  bool raise_by_plane(const Vec3& movement) {
    const Vec3 forward = movement.normalized();
    std::uint32_t rearmost = 0;
    double of_a = std::numeric_limits<double>::infinity(), of_b = of_a;
    const auto along = [&](const Vec3& p) { return pair_.frame.to_frame(p).dot(forward); };
    const auto see_a = [&](std::uint32_t v) {
      const double at = along(from_.positions[v]);
      if (at < of_a) of_a = at, rearmost = v;
    };
    const auto see_b = [&](std::uint32_t v) { of_b = std::min(of_b, along(to_.positions[v])); };
    if (!each_unless(interrupted_, from_.positions.size(), see_a)) return false;
    if (!each_unless(interrupted_, to_.positions.size(), see_b)) return false;
    if (!(of_b - of_a > lower_)) return true;
    return each_unless(interrupted_, from_.triangles.size(), [&](std::uint32_t t) {
      const auto& [a, b, c] = from_.triangles[t];
      if (a == rearmost || b == rearmost || c == rearmost) lower_ = of_b - of_a, candidate_ = t;
    });
  }

  // Raises the lower bound to the largest distance of the movers from B.
  FrontEnd measure_movers(const Movement& movement) {
    Vicinity vicinity(box_of_b());
    std::erase_if(movers_,
                  [&](std::uint32_t t) { return std::sqrt(movement.upper_sq(from_.triangles[t])) <= limit(); });
    for (const std::uint32_t t : movers_) {
      const std::uint32_t v = movement.farthest_corner(from_.triangles[t]);
      vicinity.add(Box{point(v), point(v)}, kWider * movement.of(v));
    }
    const auto near = vicinity.triangles(to_, pair_.frame, interrupted_);
    if (!near) return FrontEnd::interrupted;
    if (kMostLeft * near->size() > to_.triangles.size()) return FrontEnd::declined;
    const auto part = std::make_unique<NearPart>(direction_.to, *near, pair_.frame, control_, pool_);
    if (!part->complete()) return FrontEnd::interrupted;
    for (const std::uint32_t t : movers_) {
      std::uint64_t tests = 0;
      const Nearest nearest_of_b = nearest(part->tree, point(movement.farthest_corner(from_.triangles[t])), tests,
                                           Nearest::kNone, &interrupted_);
      if (!nearest_of_b.complete) return FrontEnd::interrupted;
      if (nearest_of_b.distance > lower_) lower_ = nearest_of_b.distance, candidate_ = t;
    }
    return FrontEnd::taken;
  }

  // Leaves out what is within the tolerance, except the candidate's triangle: the search needs it for the witness.
  FrontEnd leave_out(const Movement& movement) {
    const double limit_sq = limit() * limit();
    std::vector<std::uint32_t> rest;
    double left_out_sq = 0, most_sq = 0;
    const bool done = each_unless(interrupted_, from_.triangles.size(), [&](std::uint32_t t) {
      const double upper_sq = movement.upper_sq(from_.triangles[t]);
      if (upper_sq <= limit_sq && t != candidate_) {
        left_out_sq = std::max(left_out_sq, upper_sq);
      } else {
        rest.push_back(t);
        most_sq = std::max(most_sq, upper_sq);
      }
    });
    if (!done) return FrontEnd::interrupted;
    if (kMostLeft * rest.size() > from_.triangles.size()) return FrontEnd::declined;
    direction_.left_out = std::sqrt(left_out_sq);
    direction_.rest =
        std::make_unique<OrderedMesh>(from_, rest, direction_.from.prepared.box(), pair_.frame, control_, pool_);
    if (!direction_.rest->complete()) return FrontEnd::interrupted;
    const auto& original = direction_.rest->original;
    direction_.first =
        static_cast<std::uint32_t>(std::find(original.begin(), original.end(), candidate_) - original.begin());
    return find_near(kWider * std::sqrt(most_sq));
  }

  // The part of B within `reach` of the rest, if it is small enough to be worth a tree of its own.
  FrontEnd find_near(double reach) {
    Vicinity vicinity(box_of_b());
    const MeshView rest = direction_.rest->view();
    for (std::size_t t = 0; t < rest.triangles.size(); ++t) {
      Box box;
      for (int i = 0; i < 3; ++i) box.extend(rest.corner(t, i));
      vicinity.add(box, reach);
    }
    const auto near = vicinity.triangles(to_, pair_.frame, interrupted_);
    if (!near) return FrontEnd::interrupted;
    if (kMostLeft * near->size() > to_.triangles.size()) return FrontEnd::taken;
    direction_.near = std::make_unique<NearPart>(direction_.to, *near, pair_.frame, control_, pool_);
    direction_.reach = reach;
    return direction_.near->complete() ? FrontEnd::taken : FrontEnd::interrupted;
  }

  Vec3 point(std::uint32_t vertex) const { return pair_.frame.to_frame(from_.positions[vertex]); }
  Box box_of_b() const {
    const Box& box = direction_.to.prepared.box();
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
  std::vector<std::uint32_t> movers_;  // triangles of A
  std::uint32_t candidate_ = 0;        // the triangle of A with the vertex that lower_ is the distance of
};

}  // namespace

FrontEnd take_front(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, Slack slack,
                    double& known, Control& control, ThreadPool& pool) {
  slack.residual = rounding::kUsualResidual;
  MovementFront front(pair, direction, goal, slack, known, control, pool);
  const FrontEnd end = front.run();
  if (end == FrontEnd::taken) known = front.lower();
  return end;
}

}  // namespace meshgauge
