#include "api/compare.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "api/digest.h"

namespace meshgauge::api {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Before both meshes are known there is no interval to give.
Result<Done> in_time(Control& control, const std::string& what) {
  const Interruption why = control.check();
  if (why == Interruption::none) return Done{};
  return not_in_time(why, what);
}

// One mesh of a comparison, and what messages call it.
struct Side {
  const GetMesh& get;
  std::string_view name;
};

Result<std::shared_ptr<const PreparedMesh>> get_mesh(const Side& side, Control& control, double& ms) {
  const auto start = Clock::now();
  if (auto ok = in_time(control, "'" + std::string(side.name) + "' was read"); !ok) return ok.error();
  auto mesh = side.get(control);
  ms = ms_since(start);
  return mesh;
}

FileUnit file_unit(const MeshFacts& facts, const Side& side) { return {facts.format, facts.notes.unit, side.name}; }

bool is_same(MeshView a, MeshView b) {
  return std::ranges::equal(a.positions, b.positions) && std::ranges::equal(a.triangles, b.triangles);
}

// A mesh against itself is at distance 0 in any unit, whatever its conversion rounds.
Result<Outcome> measure_in_unit(const std::shared_ptr<const PreparedMesh>& a,
                                const std::shared_ptr<const PreparedMesh>& b, const UnitPlan& plan,
                                const ComparisonOptions& options, Control& control) {
  const Factor factor_a = factor_between(plan.a, plan.result), factor_b = factor_between(plan.b, plan.result);
  const auto measured_a = in_unit(a, "a", factor_a, control);
  if (!measured_a) return measured_a.error();
  if (!factor_a.is_one() && factor_a == factor_b && is_same(a->mesh.mesh(), b->mesh.mesh())) {
    const Prepared exact((*measured_a)->mesh(), Prepared::Use::once, *measured_a);
    return measure(exact, exact, options, control);
  }
  const auto measured_b = in_unit(b, "b", factor_b, control);
  if (!measured_b) return measured_b.error();
  return measure(**measured_a, **measured_b, options, control);
}

Result<Comparison> run(const Side& side_a, const Side& side_b, const ComparisonOptions& options, Control& control) {
  const auto start = Clock::now();
  Comparison comparison;
  comparison.id = random_id();
  comparison.options = options;
  const auto a = get_mesh(side_a, control, comparison.times.read_a);
  if (!a) return a.error();
  const auto b = get_mesh(side_b, control, comparison.times.read_b);
  if (!b) return b.error();
  if (auto ok = in_time(control, "both meshes were read"); !ok) return ok.error();
  comparison.a = (*a)->facts;
  comparison.b = (*b)->facts;
  const auto plan = resolve(file_unit(comparison.a, side_a), file_unit(comparison.b, side_b), options.units,
                            options.max_distance.has_value());
  if (!plan) return plan.error();
  comparison.units = *plan;
  auto outcome = measure_in_unit(*a, *b, *plan, options, control);
  if (!outcome) return outcome.error();
  comparison.outcome = std::move(*outcome);
  comparison.times.total = ms_since(start);
  return comparison;
}

Result<Comparison> run_guarded(const Side& a, const Side& b, const ComparisonOptions& options, Control& control) {
  try {
    return run(a, b, options, control);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::internal, "not enough memory for this comparison", "", ""};
  } catch (const std::exception&) {
    return Error{ErrorCode::internal, "the comparison failed unexpectedly", "", ""};
  }
}

}  // namespace

Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const ComparisonOptions& options,
                           const ReadLimits& limits, Control& control) {
  return compare_by(&api::load, a, b, options, limits, control);
}

Result<Comparison> compare_by(const Load& load, const MeshInput& a, const MeshInput& b,
                              const ComparisonOptions& options, const ReadLimits& limits, Control& control) {
  const GetMesh get_a = loading(load, a, limits, Prepared::Use::once);
  const GetMesh get_b = loading(load, b, limits, Prepared::Use::once);
  return run_guarded({get_a, a.part}, {get_b, b.part}, options, control);
}

Result<Comparison> compare_prepared(const GetMesh& a, const GetMesh& b, const ComparisonOptions& options,
                                    Control& control) {
  return run_guarded({a, "a"}, {b, "b"}, options, control);
}

}  // namespace meshgauge::api
