#include "oracle/judge.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace meshgauge::oracle {
namespace {

constexpr double kUnit = 0x1p-53;

__attribute__((format(printf, 2, 3))) Violation violation(const char* check, const char* format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return {check, text};
}

// Rounding may move a point by some units of rounding of the size of both meshes and of its own magnitude.
double tolerance_of_points(const Mesh& a, const Mesh& b) {
  Vec3 low = a.positions[a.triangles[0][0]], high = low;
  for (const Mesh* mesh : {&a, &b}) {
    for (const Triangle& t : mesh->triangles) {
      for (const std::uint32_t i : t) low = low.cwiseMin(mesh->positions[i]), high = high.cwiseMax(mesh->positions[i]);
    }
  }
  const double width = (high - low).maxCoeff();
  const double magnitude = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  return 512 * kUnit * width + 8 * kUnit * magnitude + 16 * std::numeric_limits<double>::denorm_min();
}

std::optional<Violation> judge_interval(const char* what, double lower, double upper) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) {
    return violation("finite", "%s [%.17g, %.17g]", what, lower, upper);
  }
  if (lower < 0 || lower > upper) return violation("order", "%s [%.17g, %.17g]", what, lower, upper);
  return std::nullopt;
}

std::optional<Violation> judge_combination(const Options& options, const Outcome& outcome) {
  const bool wants_a = options.direction != Direction::b_to_a, wants_b = options.direction != Direction::a_to_b;
  if (outcome.a_to_b.has_value() != wants_a || outcome.b_to_a.has_value() != wants_b) {
    return violation("combine", "the directions are not those asked for");
  }
  Bounds largest;
  for (const auto* directed : {&outcome.a_to_b, &outcome.b_to_a}) {
    if (!*directed) continue;
    largest.lower = std::max(largest.lower, (*directed)->bounds.lower);
    largest.upper = std::max(largest.upper, (*directed)->bounds.upper);
  }
  if (outcome.lower == largest.lower && outcome.upper == largest.upper) return std::nullopt;
  return violation("combine", "outcome [%.17g, %.17g], maximum of the directions [%.17g, %.17g]", outcome.lower,
                   outcome.upper, largest.lower, largest.upper);
}

// The largest width of an interval with these numbers that meets the rule.
std::optional<double> width_of(Rule rule, const Tolerance& tolerance, const Outcome& outcome) {
  if (rule == Rule::absolute) return tolerance.absolute;
  if (rule == Rule::diagonal && tolerance.diagonal) return *tolerance.diagonal * outcome.diagonal_a;
  if (rule == Rule::relative && tolerance.relative) return *tolerance.relative * outcome.lower;
  return std::nullopt;
}

std::optional<Violation> judge_rules(const Options& options, const Outcome& outcome) {
  const double width = outcome.upper - outcome.lower;
  if (outcome.met_by) {
    const auto allowed = width_of(*outcome.met_by, options.tolerance, outcome);
    if (!allowed || !(width <= *allowed)) return violation("rule", "a rule is reported that does not hold: %g", width);
  }
  if (outcome.stop == Stop::converged && !outcome.met_by) return violation("rule", "converged by no rule");
  for (const Rule rule : {Rule::absolute, Rule::diagonal, Rule::relative}) {
    const auto allowed = width_of(rule, options.tolerance, outcome);
    if (!allowed) continue;
    if (width <= *allowed && !outcome.met_by)
      return violation("rule", "rule %d holds but is not reported", static_cast<int>(rule));
    if (outcome.stop == Stop::precision_floor && *allowed > outcome.precision_floor) {
      return violation("floor", "stopped at width %.17g, a rule allows %.17g, the floor is %.17g", width, *allowed,
                       outcome.precision_floor);
    }
  }
  if (outcome.stop == Stop::precision_floor && !(width <= outcome.precision_floor)) {
    return violation("floor", "width %.17g of [%.17g, %.17g] is above the floor %.17g", width, outcome.lower,
                     outcome.upper, outcome.precision_floor);
  }
  return std::nullopt;
}

std::optional<Violation> judge_stop(const Options& options, const Outcome& outcome, const Circumstances& happened) {
  const auto& gate = options.max_distance;
  const bool decided = gate && (outcome.upper <= *gate || outcome.lower > *gate);
  if (outcome.stop == Stop::gate_decided && !decided) return violation("stop", "the gate is not decided");
  if (decided && outcome.stop != Stop::gate_decided && outcome.stop != Stop::converged) {
    return violation("stop", "the gate is decided, but the stop reason is %d", static_cast<int>(outcome.stop));
  }
  if (outcome.stop == Stop::timeout && !happened.deadline) return violation("stop", "timeout without a deadline");
  if (outcome.stop == Stop::cancelled && !happened.cancelled)
    return violation("stop", "cancelled without a cancellation");
  if (outcome.stop == Stop::budget && !happened.budget) return violation("stop", "budget spent, but there is none");
  return std::nullopt;
}

std::optional<Violation> judge_diagonal(const Surface& a, const Outcome& outcome) {
  Point low = a[0][0], high = low;
  for (const Corners& t : a) {
    for (const Point& p : t) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  const Point size = high - low;
  const Ratio diagonal_sq{dot(size, size), 1.0};
  const double slack = 4 * kUnit * outcome.diagonal_a + 4 * std::numeric_limits<double>::denorm_min();
  if (root_at_least(diagonal_sq, std::max(0.0, outcome.diagonal_a - slack)) &&
      root_at_most(diagonal_sq, outcome.diagonal_a + slack)) {
    return std::nullopt;
  }
  return violation("diagonal", "%.17g reported, %.17g is true", outcome.diagonal_a, diagonal_sq.approximate_root());
}

}  // namespace

Judge::Judge(const Mesh& a, const Mesh& b, const Effort& effort)
    : effort_(effort), point_tolerance_(tolerance_of_points(a, b)) {
  const Surface surface_a = surface_of(a), surface_b = surface_of(b);
  sides_[0] = {&a, &b, surface_a, surface_b, {}, {}, {}};
  sides_[1] = {&b, &a, surface_b, surface_a, {}, {}, {}};
}

const Farthest& Judge::farthest(Side& side) {
  if (!side.farthest) side.farthest = farthest_sample(side.from_surface, side.to_surface, effort_.max_points);
  return *side.farthest;
}

const Bracket& Judge::bracket(Side& side) {
  if (!side.bracket) side.bracket = exact_bracket(side.from_surface, side.to_surface, effort_.max_splits);
  return *side.bracket;
}

const Ratio& Judge::distance_to_sq(Side& side, const Vec3& point) {
  for (const auto& known : side.known) {
    if (known.point == point) return known.distance_sq;
  }
  side.known.push_back({point, distance_sq(exact(point), side.to_surface)});
  return side.known.back().distance_sq;
}

Ratio Judge::largest_seen_sq(Direction direction) {
  if (direction != Direction::symmetric) return farthest(side(direction)).distance_sq;
  return std::max(farthest(sides_[0]).distance_sq, farthest(sides_[1]).distance_sq);
}

std::optional<Violation> Judge::judge(const Options& options, const Outcome& outcome,
                                      const Circumstances& circumstances) {
  if (auto v = judge_interval("outcome", outcome.lower, outcome.upper)) return v;
  if (!(outcome.precision_floor >= 0) || !std::isfinite(outcome.precision_floor)) {
    return violation("finite", "precision_floor %g", outcome.precision_floor);
  }
  if (auto v = judge_combination(options, outcome)) return v;
  if (auto v = judge_rules(options, outcome)) return v;
  if (auto v = judge_stop(options, outcome, circumstances)) return v;
  if (auto v = judge_diagonal(sides_[0].from_surface, outcome)) return v;
  for (const auto* directed : {&outcome.a_to_b, &outcome.b_to_a}) {
    if (!*directed) continue;
    if (auto v = judge_directed(sides_[directed == &outcome.a_to_b ? 0 : 1], **directed)) {
      v->detail += directed == &outcome.a_to_b ? " (a to b)" : " (b to a)";
      return v;
    }
  }
  return std::nullopt;
}

std::optional<Violation> Judge::judge_directed(Side& side, const Directed& directed) {
  const Bounds& bounds = directed.bounds;
  if (auto v = judge_interval("direction", bounds.lower, bounds.upper)) return v;
  if (directed.culling.triangles != side.from->triangles.size() ||
      directed.culling.survivors > directed.culling.triangles) {
    return violation("culling", "%zu survivors of %zu triangles", directed.culling.survivors,
                     directed.culling.triangles);
  }
  if (auto v = judge_upper(side, bounds)) return v;
  if (!bounds.witness) {
    if (bounds.lower == 0) return std::nullopt;
    return violation("lower", "%.17g without a witness", bounds.lower);
  }
  return judge_witness(side, bounds, *bounds.witness);
}

std::optional<Violation> Judge::judge_upper(Side& side, const Bounds& bounds) {
  const Farthest& seen = farthest(side);
  if (!root_at_most(seen.distance_sq, bounds.upper)) {
    return violation("upper", "upper %.17g, but a sample on triangle %zu (weights %.17g %.17g) is at %.17g",
                     bounds.upper, seen.where.triangle, seen.where.weights.first, seen.where.weights.second,
                     seen.distance_sq.approximate_root());
  }
  if (effort_.max_splits == 0) return std::nullopt;
  const Bracket& exact = bracket(side);
  if (exact.lower_sq > exact.upper_sq) return violation("bracket", "the oracle contradicts itself");
  if (root_at_most(exact.lower_sq, bounds.upper) && root_at_least(exact.upper_sq, bounds.lower)) return std::nullopt;
  return violation("bracket", "[%.17g, %.17g] does not meet the exact bracket [%.17g, %.17g]", bounds.lower,
                   bounds.upper, exact.lower_sq.approximate_root(), exact.upper_sq.approximate_root());
}

std::optional<Violation> Judge::judge_witness(Side& side, const Bounds& bounds, const Witness& witness) const {
  if (witness.triangle_a >= side.from->triangles.size() || witness.triangle_b >= side.to->triangles.size()) {
    return violation("witness", "triangles %u and %u do not exist", witness.triangle_a, witness.triangle_b);
  }
  if (!witness.point_a.allFinite() || !witness.point_b.allFinite()) return violation("finite", "witness");
  if (bounds.lower == 0) return judge_points(side, witness);  // a bound of 0 always holds
  const Ratio& to_b = distance_to_sq(side, witness.point_a);
  const Ratio to_a = distance_sq(exact(witness.point_a), side.from_surface[witness.triangle_a]);
  if (!root_at_least(to_b, bounds.lower) || !difference_at_least(to_b, to_a, bounds.lower)) {
    return violation("lower", "lower %.17g, but the witness is at %.17g and %g off its own triangle", bounds.lower,
                     to_b.approximate_root(), to_a.approximate_root());
  }
  return judge_points(side, witness);
}

std::optional<Violation> Judge::judge_points(Side& side, const Witness& witness) const {
  const Point a = exact(witness.point_a), b = exact(witness.point_b);
  const Ratio off_a = distance_sq(a, side.from_surface[witness.triangle_a]);
  if (!root_at_most(off_a, point_tolerance_)) {
    return violation("witness", "point_a is %g off triangle_a, allowed %g", off_a.approximate_root(), point_tolerance_);
  }
  const Ratio off_b = distance_sq(b, side.to_surface[witness.triangle_b]);
  if (!root_at_most(off_b, point_tolerance_)) {
    return violation("witness", "point_b is %g off triangle_b, allowed %g", off_b.approximate_root(), point_tolerance_);
  }
  // |a-b| <= d(a,B) + tolerance; the other way round it holds because b is near B.
  const Ratio apart{dot(a - b, a - b), 1.0};
  const Ratio& to_b = distance_to_sq(side, witness.point_a);
  if (apart > to_b && difference_at_least(apart, to_b, point_tolerance_)) {
    return violation("witness", "point_b is at %.17g, but the nearest point is at %.17g, allowed %g",
                     apart.approximate_root(), to_b.approximate_root(), point_tolerance_);
  }
  return std::nullopt;
}

}  // namespace meshgauge::oracle
