#include "engine/search/certify.h"

#include <algorithm>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

// Returns r >= d(w, triangle).
double distance_above(MeshView mesh, std::uint32_t triangle, const Vec3& w) {
  const Vec3 &a = mesh.corner(triangle, 0), &b = mesh.corner(triangle, 1), &c = mesh.corner(triangle, 2);
  if (w == a || w == b || w == c) return 0;
  const Preparation prepared = prepare(a, b, c);
  return rounding::add_up(distance(prepared.triangle, w), rounding::kDistanceSlack + prepared.residual);
}

}  // namespace

Certifier::Known Certifier::lower_bound(const Search& search, const Frame& frame, const Interrupted& stop) {
  const Candidate& candidate = search.candidate();
  Witness witness;
  witness.triangle_a = candidate.triangle;
  witness.point_a = frame.from_frame(candidate.point);
  const Vec3 w = frame.to_frame(witness.point_a);

  std::uint64_t tests = 0;
  const Nearest found = nearest(search.to(), w, tests, Nearest::kNone, &stop);
  witness.triangle_b = found.slot;
  witness.point_b = frame.from_frame(found.point);

  const double off = distance_above(search.from(), candidate.triangle, w);
  const std::optional<double> below = found.complete ? certified_distance_below(search.to(), w, &stop) : std::nullopt;
  const double beyond = rounding::subtract_down(search.reach(), off);  // from the triangles that are not in the tree
  const double lower = below ? rounding::subtract_down(std::min(*below, beyond), off) : 0;
  return {candidate.point, candidate.triangle, lower, witness, below.has_value()};
}

// Both bound the same number, so the lower bound is never above the upper one.
Bounds Certifier::certify(const Search& search, const Frame& frame, const Interrupted& stop) {
  const Candidate& candidate = search.candidate();
  if (!known_ || known_->candidate != candidate.point || known_->triangle != candidate.triangle) {
    const Known found = lower_bound(search, frame, stop);
    if (found.complete || !known_) known_ = found;
  }
  const double upper = rounding::add_up(search.upper(), search.upper_slack());
  return {rounding::scale_down(known_->lower, frame.exponent()), rounding::scale_up(upper, frame.exponent()),
          known_->witness};
}

}  // namespace meshgauge
