#include "api/compare.h"

#include <chrono>
#include <exception>
#include <new>

#include "api/digest.h"

namespace meshgauge::api {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Wrong if `control` says to stop meanwhile; then in_time() says so before anybody looks.
MeshFacts facts_of(const MeshInput& input, const LoadedMesh& loaded, Control& control) {
  const Interrupted interrupted = [&control] { return control.check() != Interruption::none; };
  MeshFacts facts;
  facts.format = loaded.format;
  facts.bytes = input.bytes.size();
  facts.sha256 = loaded.sha256;
  facts.vertices = loaded.mesh.positions.size();
  facts.triangles = loaded.mesh.triangles.size();
  facts.degenerate = count_degenerate(loaded.mesh, interrupted);
  facts.bbox = bounding_box(loaded.mesh, interrupted);
  facts.diagonal = diagonal(facts.bbox);
  facts.notes = loaded.notes;
  return facts;
}

// Before both meshes are known there is no interval to give.
Result<Done> in_time(Control& control, const std::string& what) {
  const Interruption why = control.check();
  if (why == Interruption::none) return Done{};
  return not_in_time(why, what);
}

struct Side {
  LoadedMesh loaded;
  MeshFacts facts;
};

Result<Side> load_side(const Load& load, const MeshInput& input, const ReadLimits& limits, Control& control,
                       double& ms) {
  const auto start = Clock::now();
  if (auto ok = in_time(control, "'" + input.part + "' was read"); !ok) return ok.error();
  auto loaded = load(input, limits, control);
  if (!loaded) return std::move(loaded).error();
  MeshFacts facts = facts_of(input, *loaded, control);
  ms = ms_since(start);
  return Side{std::move(*loaded), std::move(facts)};
}

Result<Comparison> run(const Load& load, const MeshInput& a, const MeshInput& b, const Options& options,
                       const ReadLimits& limits, Control& control) {
  const auto start = Clock::now();
  Comparison comparison;
  comparison.id = random_id();
  comparison.options = options;
  auto side_a = load_side(load, a, limits, control, comparison.times.read_a);
  if (!side_a) return side_a.error();
  auto side_b = load_side(load, b, limits, control, comparison.times.read_b);
  if (!side_b) return side_b.error();
  if (auto ok = in_time(control, "both meshes were read"); !ok) return ok.error();
  comparison.outcome = measure(side_a->loaded.mesh, side_b->loaded.mesh, options, control);
  comparison.a = std::move(side_a->facts);
  comparison.b = std::move(side_b->facts);
  comparison.times.total = ms_since(start);
  return comparison;
}

}  // namespace

Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const Options& options, const ReadLimits& limits,
                           Control& control) {
  return compare_by(&api::load, a, b, options, limits, control);
}

Result<Comparison> compare_by(const Load& load, const MeshInput& a, const MeshInput& b, const Options& options,
                              const ReadLimits& limits, Control& control) {
  try {
    return run(load, a, b, options, limits, control);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::internal, "not enough memory for this comparison", "", ""};
  } catch (const std::exception&) {
    return Error{ErrorCode::internal, "the comparison failed unexpectedly", "", ""};
  }
}

}  // namespace meshgauge::api
