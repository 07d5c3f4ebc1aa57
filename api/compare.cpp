#include "api/compare.h"

#include <chrono>
#include <exception>
#include <new>

#include "api/digest.h"
#include "api/formats/weld.h"

namespace meshgauge::api {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

struct Loaded {
  Mesh mesh;
  MeshFacts facts;
};

MeshFacts facts_of(const MeshInput& input, const ReadMesh& read) {
  MeshFacts facts;
  facts.format = read.format;
  facts.bytes = input.bytes.size();
  facts.sha256 = sha256_hex(input.bytes);
  facts.vertices = read.mesh.positions.size();
  facts.triangles = read.mesh.triangles.size();
  facts.degenerate = count_degenerate(read.mesh);
  facts.bbox = bounding_box(read.mesh);
  facts.diagonal = diagonal(facts.bbox);
  facts.notes = read.notes;
  return facts;
}

Result<Loaded> load(const MeshInput& input, const ReadLimits& limits) {
  auto read = read_mesh(input.bytes, {input.part, input.filename, input.media_type}, limits);
  if (!read) return read.error();
  // Formats without indices repeat every corner; shared vertices save the engine most of its queries.
  const bool repeats_corners = read->mesh.positions.size() == 3 * read->mesh.triangles.size();
  const std::size_t welded = repeats_corners ? weld(read->mesh) : 0;
  MeshFacts facts = facts_of(input, *read);
  facts.welded_vertices = welded;
  return Loaded{std::move(read->mesh), std::move(facts)};
}

// Before both meshes are known there is no interval to give.
Result<Done> in_time(Control& control, const std::string& what) {
  switch (control.check()) {
    case Interruption::none:
      return Done{};
    case Interruption::timeout:
      return Error{ErrorCode::out_of_time, "the time was over before " + what, "", ""};
    case Interruption::cancelled:
      break;
  }
  return Error{ErrorCode::out_of_time, "cancelled before " + what, "", ""};
}

Result<Loaded> load_in_time(const MeshInput& input, const ReadLimits& limits, Control& control, double& ms) {
  const auto start = Clock::now();
  if (auto ok = in_time(control, "'" + input.part + "' was read"); !ok) return ok.error();
  auto loaded = load(input, limits);
  ms = ms_since(start);
  return loaded;
}

Result<Comparison> run(const MeshInput& a, const MeshInput& b, const Options& options, const ReadLimits& limits,
                       Control& control) {
  const auto start = Clock::now();
  Comparison comparison;
  comparison.id = random_id();
  comparison.options = options;
  auto loaded_a = load_in_time(a, limits, control, comparison.times.read_a);
  if (!loaded_a) return loaded_a.error();
  auto loaded_b = load_in_time(b, limits, control, comparison.times.read_b);
  if (!loaded_b) return loaded_b.error();
  if (auto ok = in_time(control, "both meshes were read"); !ok) return ok.error();
  comparison.outcome = measure(loaded_a->mesh, loaded_b->mesh, options, control);
  comparison.a = std::move(loaded_a->facts);
  comparison.b = std::move(loaded_b->facts);
  comparison.times.total = ms_since(start);
  return comparison;
}

}  // namespace

Result<Comparison> compare(const MeshInput& a, const MeshInput& b, const Options& options, const ReadLimits& limits,
                           Control& control) {
  try {
    return run(a, b, options, limits, control);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::internal, "not enough memory for this comparison", "", ""};
  } catch (const std::exception&) {
    return Error{ErrorCode::internal, "the comparison failed unexpectedly", "", ""};
  }
}

}  // namespace meshgauge::api
