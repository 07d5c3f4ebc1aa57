#include "api/compare/compare.h"

#include <algorithm>
#include <cassert>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "api/base/digest.h"
#include "api/base/figures.h"
#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/formats/file/source.h"
#include "api/options/gate.h"
#include "engine/thread_pool.h"

namespace meshgauge::api {
namespace {

Result<SharedMesh> read(const MeshInput& input, const ReadLimits& limits, Control& control) {
  if (auto ok = in_time(control, "'" + input.part + "' was read"); !ok) return ok.error();
  return prepare(load(input, limits), input, Prepared::Use::once, control);
}

bool is_same(const MeshInput& a, const MeshInput& b) {
  return a.part == b.part && a.filename == b.filename && a.media_type == b.media_type &&
         std::ranges::equal(a.bytes, b.bytes);
}

// As `read`, with nullopt in place of its std::bad_alloc.
std::optional<Result<SharedMesh>> read_beside(const MeshReader& read, Control& control) try {
  return read(true, control);
} catch (const std::bad_alloc&) {
  return std::nullopt;
}

// Stops the reader of b unless a was read.
struct Stop {
  ~Stop() {
    if (!a || !a->ok()) control_b.cancel();
  }
  Control& control_b;
  const std::optional<Result<SharedMesh>>& a;
};

struct Beside {
  std::optional<Result<SharedMesh>> a, b;  // nullopt: still to be read
};

// Reads b on one of two threads if the system has another one, else after a.
Beside read_side_by_side(const MeshReader& read_a, const MeshReader& read_b, Control& control, StageTimes& times) {
  const auto start = Control::Clock::now();
  Beside both;
  Control control_b(&control);
  std::exception_ptr thrown_by_b;
  ThreadPool(2).run(2, [&](std::size_t, std::size_t mesh) {
    if (mesh == 0) {
      const Stop stop_b{control_b, both.a};
      both.a = read_beside(read_a, control);
      times.read_a = ms_since(start);
    } else if (!control_b.cancelled()) {
      try {
        both.b = read_beside(read_b, control_b);
      } catch (...) {
        thrown_by_b = std::current_exception();
      }
    }
  });
  if (!both.a) both.b.reset();
  if (both.a && both.a->ok() && thrown_by_b) std::rethrow_exception(thrown_by_b);
  return both;
}

// One mesh of a comparison and its name in messages.
struct NamedMesh {
  const SharedMesh& mesh;
  std::string_view name;

  FileUnit unit() const { return {mesh->facts.format, mesh->facts.notes.unit, name}; }
  bool is_cloud() const { return mesh->facts.notes.cloud; }
};

// The surface between the points of a cloud is not known, so no distance to it is.
Error no_distance_to(const NamedMesh& cloud, const NamedMesh& other, const std::string& from_it) {
  const std::string advice = other.is_cloud() ? "one of both needs triangles" : std::string(kAskFor) + " " + from_it;
  return about(cloud.name, ErrorCode::empty_mesh,
               "has no triangles: it is a point cloud of " + std::to_string(cloud.mesh->facts.vertices) +
                   " points, and distances are measured from it, not to it; " + advice);
}

Error no_area_of(const NamedMesh& cloud) {
  return about(cloud.name, ErrorCode::empty_mesh,
               "is a point cloud, which has no area: max_share_beyond cannot be measured; limit max_distance");
}

Result<Done> check_clouds(const NamedMesh& a, const NamedMesh& b, const ComparisonOptions& options) {
  const Direction direction = options.direction;
  if (a.is_cloud() && direction != Direction::a_to_b) return no_distance_to(a, b, "a_to_b");
  if (b.is_cloud() && direction != Direction::b_to_a) return no_distance_to(b, a, "b_to_a");
  if (options.max_share_beyond && (a.is_cloud() || b.is_cloud())) return no_area_of(a.is_cloud() ? a : b);
  return Done{};
}

bool is_same(MeshView a, MeshView b) {
  return std::ranges::equal(a.positions, b.positions) && std::ranges::equal(a.triangles, b.triangles);
}

// "'a' lies from (0, 0, 0) to (1, 1, 1)".
std::string place_of(const Prepared& mesh, std::string_view name) {
  return "'" + std::string(name) + "' lies from " + in_words(mesh.box().low) + " to " + in_words(mesh.box().high);
}

// "'foot', 'lid' and 3 more".
std::string names_of(const Groups& groups) {
  constexpr std::size_t kMostShown = 8;
  std::string names;
  for (const Group& group : std::span(groups.named).first(std::min(kMostShown, groups.named.size())))
    names += (names.empty() ? "" : ", ") + shown_text(group.name);
  const std::size_t more = groups.named.size() - std::min(kMostShown, groups.named.size());
  return more == 0 ? names : names + " and " + std::to_string(more) + " more";
}

std::string why_no_group(const Groups& groups, const std::string& mesh) {
  if (groups.too_many)
    return mesh + " has more names or parts than are kept (" + std::to_string(kMostBytesOfGroups) +
           " bytes of names, " + std::to_string(kMostGroupRanges) +
           " runs of triangles): name fewer, or split the file";
  if (groups.named.empty())
    return mesh + " has none; groups and objects of an OBJ, nodes of a glTF and objects of a 3MF are some";
  return mesh + " has " + names_of(groups);
}

// Finds the triangles of the groups that the options ask for, of mesh b. The reader of requests has accepted them.
Result<Done> find_groups(const NamedMesh& a, const NamedMesh& b, ComparisonOptions& options) {
  for (std::size_t i = 0; i < options.regions.size(); ++i) {
    auto* const group = std::get_if<Group>(&options.regions[i].shape);
    if (!group) continue;
    const std::string mesh = "'" + std::string(b.name) + "'", place = "/regions/" + std::to_string(i) + "/group";
    assert(options.direction != Direction::a_to_b);
    const Group* const found = find_group(b.mesh->groups, group->name);
    if (!found) {
      const std::string of_a =
          find_group(a.mesh->groups, group->name)
              ? "; '" + std::string(a.name) + "' has it, but regions are groups of " + mesh + " alone"
              : "";
      return refused("no group " + shown_text(group->name) + ": " + why_no_group(b.mesh->groups, mesh) + of_a,
                     "options", place);
    }
    *group = *found;
  }
  return Done{};
}

// Refuses a region without a surface, as a mistake in its numbers leaves it: its distance would be 0.
Result<Outcome> not_empty(Outcome outcome, const Prepared& a, const Prepared& b,
                          const std::pair<std::string_view, std::string_view>& names,
                          const ComparisonOptions& options) {
  for (std::size_t i = 0; i < options.regions.size(); ++i) {
    if (!outcome.regions[i].empty) continue;
    const bool from_a = options.direction != Direction::b_to_a, from_b = options.direction != Direction::a_to_b;
    const std::string of_a = from_a ? place_of(a, names.first) : "", of_b = from_b ? place_of(b, names.second) : "";
    return refused("the region " + shown_text(options.regions[i].name) +
                       " holds no point that is measured from: " + of_a + (from_a && from_b ? ", " : "") + of_b,
                   "options", "/regions/" + std::to_string(i));
  }
  return outcome;
}

// Measures in the unit of the result, mesh a after its alignment. Two equal meshes are at distance 0 in any unit: the
// rounding of their conversion does not count.
Result<Outcome> measure_in_unit(const NamedMesh& a, const NamedMesh& b, Comparison& comparison, Control& control) {
  const UnitPlan& plan = comparison.units;
  const ComparisonOptions& options = comparison.options;
  const Factor factor_a = factor_between(plan.a, plan.result), factor_b = factor_between(plan.b, plan.result);
  const auto measured_a = in_unit(a.mesh, std::string(a.name), factor_a, control);
  if (!measured_a) return measured_a.error();
  if (!options.align && !factor_a.is_one() && factor_a == factor_b &&
      is_same(a.mesh->mesh.mesh(), b.mesh->mesh.mesh())) {
    const Prepared exact((*measured_a)->mesh(), Prepared::Use::once, *measured_a);
    return not_empty(measure(exact, exact, engine_options(options), control), exact, exact, {a.name, b.name}, options);
  }
  const auto measured_b = in_unit(b.mesh, std::string(b.name), factor_b, control);
  if (!measured_b) return measured_b.error();
  if (!options.align)
    return not_empty(measure(**measured_a, **measured_b, engine_options(options), control), **measured_a, **measured_b,
                     {a.name, b.name}, options);
  const auto start = Control::Clock::now();
  const std::string part(a.name);
  const auto alignment = aligned(**measured_a, **measured_b, *options.align, options, part, control);
  if (!alignment) return alignment.error();
  comparison.alignment = *alignment;
  const auto in_place = moved(*measured_a, alignment->found.motion, part, control);
  if (!in_place) return in_place.error();
  comparison.times.align = ms_since(start);
  return not_empty(measure(**in_place, **measured_b, engine_options(options), control), **in_place, **measured_b,
                   {a.name, b.name}, options);
}

// nullopt: interrupted.
std::optional<Topology> topology_in(const KnownUnit& result, const PreparedMesh& mesh, const KnownUnit& unit,
                                    Control& control) {
  const auto found = mesh.topology([&control] { return control.check() != Interruption::none; });
  return found ? std::optional(scaled(*found, factor_between(unit, result))) : std::nullopt;
}

Result<Comparison> measured(const NamedMesh& a, const NamedMesh& b, const ComparisonOptions& options, Control& control,
                            const StageTimes& so_far) {
  const auto start = Control::Clock::now();
  if (auto ok = check_clouds(a, b, options); !ok) return std::move(ok).error();
  Comparison comparison;
  comparison.id = random_id();
  comparison.options = options;
  comparison.options.topology = options.topology || options.expect.of_topology();
  comparison.a = a.mesh->facts;
  comparison.b = b.mesh->facts;
  comparison.times = so_far;
  const auto plan = resolve(a.unit(), b.unit(), options.units, first_length(options));
  if (!plan) return plan.error();
  comparison.units = *plan;
  resolve_shares(comparison.options, b.mesh->facts.diagonal);
  if (auto ok = find_groups(a, b, comparison.options); !ok) return std::move(ok).error();
  if (comparison.options.topology) {  // linear, so before what may take all the time
    comparison.a.topology = topology_in(plan->result, *a.mesh, plan->a, control);
    comparison.b.topology = topology_in(plan->result, *b.mesh, plan->b, control);
  }
  auto outcome = measure_in_unit(a, b, comparison, control);
  if (!outcome) return outcome.error();
  comparison.outcome = std::move(*outcome);
  comparison.times.total = so_far.queue + so_far.read_a + so_far.read_b + ms_since(start);
  return comparison;
}

// Calls run() and turns its exceptions into Errors.
template <class Run>
Result<Comparison> guarded(const Run& run) try {
  return run();
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::internal, "not enough memory for this comparison", "", ""};
} catch (const std::exception&) {
  return Error{ErrorCode::internal, "the comparison failed unexpectedly", "", ""};
}

}  // namespace

MeshReader reader_here(std::function<Result<SharedMesh>(Control&)> read) {
  return [read = std::move(read)](bool beside, Control& control) -> std::optional<Result<SharedMesh>> {
    auto mesh = read(control);
    if (beside && !mesh && mesh.error().message == out_of_memory(mesh.error().part).message) return std::nullopt;
    return mesh;
  };
}

Result<SharedMeshes> read_both(const MeshReader& read_a, const MeshReader& read_b, bool side_by_side, Control& control,
                               StageTimes& times) {
  const auto start = Control::Clock::now();
  Beside both;
  if (read_b && side_by_side) both = read_side_by_side(read_a, read_b, control, times);
  if (!both.a) {
    both.a = read_a(false, control);
    times.read_a = ms_since(start);
  }
  if (!both.a->ok()) return std::move(*both.a).error();
  if (!read_b) return SharedMeshes{**both.a, **both.a};
  if (!both.b) both.b = read_b(false, control);
  if (!both.b->ok()) return std::move(*both.b).error();
  times.read_b = ms_since(start) - times.read_a;
  return SharedMeshes{**both.a, **both.b};
}

Result<Comparison> compare(const SharedMesh& a, const SharedMesh& b, const ComparisonOptions& options, Control& control,
                           const StageTimes& so_far) {
  return guarded([&] { return measured({a, "a"}, {b, "b"}, options, control, so_far); });
}

Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const ComparisonOptions& options,
                           const ReadLimits& limits, Control& control, SharedMeshes* meshes) {
  return guarded([&]() -> Result<Comparison> {
    const auto reader = [&](const MeshInput& input) {
      return reader_here([&](Control& reading) { return read(input, limits, reading); });
    };
    StageTimes times;
    const bool side_by_side = reads_side_by_side(options.threads, std::min(a.bytes.size(), b.bytes.size()));
    const auto both = read_both(reader(a), is_same(a, b) ? nullptr : reader(b), side_by_side, control, times);
    if (!both) return both.error();
    if (meshes != nullptr) *meshes = *both;
    return measured({both->a, a.part}, {both->b, b.part}, options, control, times);
  });
}

Result<MeasuredPair> in_unit_of_result(const SharedMesh& a, const SharedMesh& b, const UnitPlan& units,
                                       const std::optional<RigidMotion>& motion, Control& control) {
  auto measured_a = in_unit(a, "a", factor_between(units.a, units.result), control);
  if (!measured_a) return std::move(measured_a).error();
  if (motion) measured_a = moved(*measured_a, *motion, "a", control);
  if (!measured_a) return std::move(measured_a).error();
  auto measured_b = in_unit(b, "b", factor_between(units.b, units.result), control);
  if (!measured_b) return std::move(measured_b).error();
  return MeasuredPair{*std::move(measured_a), *std::move(measured_b)};
}

}  // namespace meshgauge::api
