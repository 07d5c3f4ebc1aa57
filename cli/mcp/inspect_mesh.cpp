// The tool inspect_mesh: facts of one mesh.
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "api/base/figures.h"
#include "api/base/units.h"
#include "api/compare/load.h"
#include "api/compare/prepared_mesh.h"
#include "api/compare/unit_plan.h"
#include "api/result/json_of.h"
#include "api/result/notes.h"
#include "check/reports/wording.h"
#include "cli/mcp/tool.h"

namespace meshgauge::mcp {
namespace {

constexpr std::size_t kMostGroupNames = 64;

struct Inspected {
  MeshArgument mesh;
  std::optional<api::LengthUnit> unit;
};

Json inspect_input() {
  const std::string units = "The file's unit, whatever it says itself: " + api::unit_names();
  return object_schema({{"mesh", mesh_schema("The mesh to examine")}, {"unit", schema_of("string", units)}}, {"mesh"});
}

Json inspect_output() {
  Json schema{{"type", "object"}, {"properties", Json::object()}};
  Json& found = schema["properties"];
  found["format"] = schema_of("string", "obj, stl, ply, off, gltf, glb, 3mf or xyz");
  found["unit"] = schema_of("object", "The unit of all lengths: its name, or null, and its source");
  found["vertices"] = schema_of("integer", "Number of vertices");
  found["triangles"] = schema_of("integer", "Number of triangles; 0: a point cloud");
  found["degenerate"] = schema_of("integer", "Number of triangles without area");
  found["bbox"] = schema_of("object", "The box along the axes: its corners low and high");
  found["diagonal"] = schema_of("number", "The length of the box's diagonal");
  found["area"] = schema_of({"number", "null"}, "The area of the surface, rounded; null: too large for a number");
  found["topology"] = schema_of({"object", "null"},
                                "null: a point cloud; watertight, oriented, components, open edges and others; volume: "
                                "certified bounds, null where the mesh is not watertight and oriented");
  found["groups"] = schema_of("array", "Names of groups, which may be regions of a comparison; at most 64 of them");
  found["notes"] = schema_of("array", "What was left out, merged or not read");
  schema["required"] = {"format", "unit", "vertices", "triangles", "bbox", "area", "topology", "notes"};
  return schema;
}

std::optional<api::LengthUnit> read_unit_name(const nlohmann::json& value, const std::string& at,
                                              api::Reading& reading) {
  const auto unit = value.is_string() ? api::parse_unit(value.get_ref<const std::string&>()) : std::nullopt;
  if (!unit) reading.refuse(at, "must be a unit of length (" + api::unit_names() + "), not " + reading.shown(value));
  return unit;
}

Inspected read_inspected(ToolCall& call, std::vector<api::RequestMistake>& mistakes) {
  const nlohmann::json arguments = std::exchange(call.arguments, nullptr);
  Inspected asked;
  api::Reading reading(kArguments);
  const api::Reading::Member members[] = {
      {"mesh", [&](const auto& value, const std::string& at) { asked.mesh = read_mesh_argument(value, at, reading); }},
      {"unit", [&](const auto& value, const std::string& at) { asked.unit = read_unit_name(value, at, reading); }}};
  reading.members(arguments, members, "");
  if (!arguments.contains("mesh")) reading.refuse("/mesh", "is missing: name a mesh");
  mistakes = reading.told();
  return asked;
}

api::KnownUnit unit_of(const api::MeshFacts& facts, const std::optional<api::LengthUnit>& declared) {
  if (declared) return {declared, api::UnitSource::declared};
  return {facts.notes.unit, facts.notes.unit ? api::UnitSource::file : api::UnitSource::unknown};
}

// The sum over the triangles, rounded.
double area_of(MeshView mesh) {
  double doubled = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& first = mesh.corner(t, 0);
    doubled += norm((mesh.corner(t, 1) - first).cross(mesh.corner(t, 2) - first));
  }
  return doubled / 2;
}

Json group_names(const api::Groups& groups) {
  Json names = Json::array();
  for (std::size_t i = 0; i < groups.named.size() && i < kMostGroupNames; ++i) names.push_back(groups.named[i].name);
  return names;
}

std::string topology_in_words(const Topology& topology, const std::string& unit) {
  std::string text = std::string(topology.watertight() ? "watertight" : "not watertight") + ", " +
                     (topology.oriented() ? "oriented" : "not oriented") +
                     ", components: " + api::grouped(topology.components) +
                     ", open edges: " + api::grouped(topology.open.count) +
                     ", non-manifold edges: " + api::grouped(topology.non_manifold.count) + "\n";
  if (!topology.volume) return text;
  text += "volume: " + api::with_unit(api::to_digits(topology.volume->lower, 9), unit.empty() ? unit : unit + "^3");
  return text + (topology.volume->upper < 0 ? ": its triangles face inwards\n" : "\n");
}

// `topology`: nullopt: a point cloud.
std::string facts_in_words(const api::PreparedMesh& mesh, const std::string& name,
                           const std::optional<Topology>& topology, const api::KnownUnit& known) {
  const api::MeshFacts& facts = mesh.facts;
  const std::string unit(api::to_string(known.unit));
  std::string text = name + ": " + std::string(api::to_string(facts.format)) + ", " +
                     (unit.empty() ? "of unknown unit" : "in " + unit) + ", " + api::grouped(facts.triangles) +
                     " triangles, " + api::grouped(facts.vertices) + " vertices\n";
  if (topology) text += topology_in_words(*topology, unit);
  text += "box: from " + api::in_words(facts.bbox.low) + " to " + api::with_unit(api::in_words(facts.bbox.high), unit);
  for (const std::string& note : api::notes_of(facts)) text += "\nnote: " + note;
  return check::shown_text(text);
}

ToolAnswer run_inspect(const Context& context, ToolCall& call) {
  std::vector<api::RequestMistake> mistakes;
  Inspected asked = read_inspected(call, mistakes);
  if (!mistakes.empty()) return failure(mistakes);
  const auto file = GivenMesh::open(std::move(asked.mesh), "mesh", *context.confines);
  if (!file) return failure(file.error());
  call.control.set_deadline(Control::Clock::now() + context.times.max_timeout);
  const auto mesh = api::prepare(api::load(file->input(), context.confines->limits), file->input(), Prepared::Use::once,
                                 call.control);
  if (!mesh) return failure(mesh.error());
  const bool is_cloud = (*mesh)->facts.triangles == 0;
  std::optional<Topology> topology;
  if (!is_cloud) topology = (*mesh)->topology([&] { return call.control.check() != Interruption::none; });
  if (!topology && !is_cloud)
    return failure(api::not_in_time(call.control.check(), "'" + file->name() + "' was examined"));
  const api::KnownUnit unit = unit_of((*mesh)->facts, asked.unit);
  Json found = api::json_of((*mesh)->facts, unit);
  const double area = is_cloud ? 0 : area_of((*mesh)->mesh.mesh());
  found["area"] = std::isfinite(area) ? Json(area) : Json();
  found["topology"] = api::json_of(topology);
  found["groups"] = group_names((*mesh)->groups);
  return {facts_in_words(**mesh, file->name(), topology, unit), std::move(found), {}};
}

}  // namespace

constinit const Tool kInspectMesh{
    "inspect_mesh",
    "Inspect a mesh",
    "Reads one mesh file and says what it is: triangles, box, area, whether it is watertight and oriented, components, "
    "certified volume, unit, groups, and what was not read of it.",
    inspect_input,
    inspect_output,
    run_inspect};

}  // namespace meshgauge::mcp
