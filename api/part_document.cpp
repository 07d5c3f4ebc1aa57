#include "api/part_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/digest.h"
#include "api/json_filter.h"
#include "api/json_of.h"
#include "api/names.h"
#include "engine/conclusion.h"
#include "engine/part.h"

namespace meshgauge::api {
namespace {

// Of all machines that may have measured a part.
constexpr std::array<std::string_view, 5> kSimd{"avx512", "avx2", "sse4", "neon", "scalar"};
constexpr std::array kFormats{Format::obj,  Format::stl, Format::ply,     Format::off,
                              Format::gltf, Format::glb, Format::three_mf};
constexpr std::array kUnits{LengthUnit::micron, LengthUnit::millimeter, LengthUnit::centimeter,
                            LengthUnit::meter,  LengthUnit::inch,       LengthUnit::foot};

Error wrong(const std::string& what) { return Error{ErrorCode::internal, "a part of a comparison " + what, "", ""}; }

// Reading believes types alone, by the exceptions of the library; read_part() does the rest.

template <class Named, std::size_t N>
Named named(const std::array<Named, N>& all, const Json& text) {
  const auto& wanted = text.get_ref<const std::string&>();
  const auto found = std::find_if(all.begin(), all.end(), [&](Named value) { return to_string(value) == wanted; });
  return found == all.end() ? all.front() : *found;  // writing it again shows the difference
}

template <class Named, std::size_t N>
std::optional<Named> named_or_none(const std::array<Named, N>& all, const Json& text) {
  return text.is_null() ? std::nullopt : std::optional(named(all, text));
}

Vec3 point_of(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

std::optional<Directed> directed_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  Directed directed;
  directed.bounds = {json.at("lower").get<double>(), json.at("upper").get<double>(), std::nullopt};
  if (const Json& witness = json.at("witness"); !witness.is_null()) {
    directed.bounds.witness = {point_of(witness.at("point_a")), witness.at("triangle_a").get<std::uint32_t>(),
                               point_of(witness.at("point_b")), witness.at("triangle_b").get<std::uint32_t>()};
  }
  const Json& culling = json.at("culling");
  directed.culling = {culling.at("triangles").get<std::size_t>(), culling.at("survivors").get<std::size_t>()};
  const Json& work = json.at("work");
  directed.work = {work.at("nearest_queries").get<std::uint64_t>(), work.at("cache_hits").get<std::uint64_t>(),
                   work.at("triangle_tests").get<std::uint64_t>(),  work.at("subdivisions").get<std::uint64_t>(),
                   work.at("max_depth").get<std::uint32_t>(),       work.at("peak_heap").get<std::size_t>()};
  return directed;
}

MeshFacts facts_of(const Json& json) {
  MeshFacts facts;
  facts.format = named(kFormats, json.at("format"));
  if (const Json& mismatch = json.at("format_mismatch"); !mismatch.is_null()) {
    facts.notes.filename_says = named_or_none(kFormats, mismatch.at("file_name"));
    facts.notes.media_type_says = named_or_none(kFormats, mismatch.at("media_type"));
  }
  facts.notes.unit = named_or_none(kUnits, json.at("unit"));
  facts.bytes = json.at("bytes").get<std::size_t>();
  facts.sha256 = json.at("sha256").get<std::string>();
  facts.vertices = json.at("vertices").get<std::size_t>();
  facts.triangles = json.at("triangles").get<std::size_t>();
  facts.degenerate = json.at("degenerate").get<std::size_t>();
  facts.bbox = {point_of(json.at("bbox").at("low")), point_of(json.at("bbox").at("high"))};
  facts.diagonal = json.at("diagonal").get<double>();
  facts.notes.gzip = json.at("gzip").get<bool>();
  const Json& polygons = json.at("polygons");
  facts.notes.polygons = {polygons.at("count").get<std::size_t>(), polygons.at("concave").get<std::size_t>(),
                          polygons.at("non_planar").get<std::size_t>(), polygons.at("self_crossing").get<std::size_t>(),
                          polygons.at("largest_deviation").get<double>()};
  facts.notes.skipped_primitives = json.at("skipped_primitives").get<std::size_t>();
  facts.notes.unused_objects = json.at("unused_objects").get<std::size_t>();
  facts.notes.helper_objects = json.at("helper_objects").get<std::size_t>();
  facts.notes.welded_vertices = json.at("welded_vertices").get<std::size_t>();
  return facts;
}

struct StageField {
  const char* name;
  double Timings::*ms;
};
constexpr StageField kStages[] = {{"build", &Timings::build},
                                  {"traverse", &Timings::traverse},
                                  {"reduce", &Timings::reduce},
                                  {"certify", &Timings::certify}};
struct TimeField {
  const char* name;
  double StageTimes::*ms;
};
constexpr TimeField kTimes[] = {
    {"read_a", &StageTimes::read_a}, {"read_b", &StageTimes::read_b}, {"total", &StageTimes::total}};

Json timings(const Comparison& part) {
  Json json;
  for (const StageField& stage : kStages) json[stage.name] = part.outcome.timings.*stage.ms;
  for (const TimeField& time : kTimes) json[time.name] = part.times.*time.ms;
  return json;
}

Comparison part_of(const Json& json) {
  Comparison part;
  Outcome& outcome = part.outcome;
  const Json& which = json.at("part");
  part.options.part = {which.at("index").get<unsigned>(), which.at("count").get<unsigned>()};
  outcome.stop = value_of(kStops, json.at("stop").get_ref<const std::string&>()).value_or(Stop::converged);
  outcome.a_to_b = directed_of(json.at("a_to_b"));
  outcome.b_to_a = directed_of(json.at("b_to_a"));
  take_maximum(outcome);
  outcome.precision_floor = json.at("precision_floor").get<double>();
  outcome.diagonal_a = json.at("diagonal_a").get<double>();
  const auto& simd = json.at("simd").get_ref<const std::string&>();
  const auto found = std::find(kSimd.begin(), kSimd.end(), simd);
  outcome.simd = found == kSimd.end() ? kSimd.back() : *found;
  outcome.threads = json.at("threads").get<unsigned>();
  const Json& ms = json.at("timings_ms");
  for (const StageField& stage : kStages) outcome.timings.*stage.ms = ms.at(stage.name).get<double>();
  for (const TimeField& time : kTimes) part.times.*time.ms = ms.at(time.name).get<double>();
  part.a = facts_of(json.at("meshes").at("a"));
  part.b = facts_of(json.at("meshes").at("b"));
  return part;
}

bool makes_sense(const std::optional<Directed>& directed, const MeshFacts& from, const MeshFacts& to) {
  if (!directed) return true;
  const auto& [lower, upper, witness] = directed->bounds;
  if (!(0 <= lower && lower <= upper && std::isfinite(upper)) || (lower > 0 && !witness)) return false;
  if (directed->culling.triangles > from.triangles || directed->culling.survivors > directed->culling.triangles) {
    return false;
  }
  return !witness || (witness->triangle_a < from.triangles && witness->triangle_b < to.triangles &&
                      witness->point_a.allFinite() && witness->point_b.allFinite());
}

bool makes_sense(const Comparison& part) {
  const Outcome& outcome = part.outcome;
  const auto counts = [](double x) { return std::isfinite(x) && x >= 0; };
  return part.options.part.index < part.options.part.count && part.options.part.count <= kShardsRange.high &&
         (outcome.a_to_b || outcome.b_to_a) && counts(outcome.precision_floor) && counts(outcome.diagonal_a) &&
         outcome.threads > 0 && makes_sense(outcome.a_to_b, part.a, part.b) &&
         makes_sense(outcome.b_to_a, part.b, part.a);
}

// What must be the same in all parts of one comparison.
Json common(const Comparison& part) {
  return {{"a", json_of(part.a)}, {"b", json_of(part.b)}, {"diagonal_a", part.outcome.diagonal_a}};
}

std::size_t measured(const std::optional<Directed>& directed) { return directed ? directed->culling.triangles : 0; }

// Why the parts, by index, are not those of `request`.
std::optional<std::string> mismatch(std::span<const Comparison> parts, const Request& request) {
  const Direction direction = request.options.direction;
  const MeshFacts &a = parts.front().a, &b = parts.front().b;
  const Json expected = common(parts.front());
  std::size_t of_a = 0, of_b = 0;
  for (const Comparison& part : parts) {
    if (common(part) != expected) return "is of other meshes than the others";
    if (part.outcome.a_to_b && direction == Direction::b_to_a) return "is of another direction";
    if (part.outcome.b_to_a && direction == Direction::a_to_b) return "is of another direction";
    of_a += measured(part.outcome.a_to_b);
    of_b += measured(part.outcome.b_to_a);
  }
  const bool is_whole = of_a == (direction == Direction::b_to_a ? 0 : a.triangles) &&
                        of_b == (direction == Direction::a_to_b ? 0 : b.triangles);
  return is_whole ? std::nullopt : std::optional<std::string>("leaves triangles out");
}

Result<std::vector<Comparison>> read_all(std::span<const std::string> documents, unsigned count) {
  if (documents.size() != count) return wrong("is missing");
  std::vector<Comparison> parts(count);
  std::vector<bool> seen(count);
  for (const std::string& document : documents) {
    auto part = read_part(document);
    if (!part) return part.error();
    const Part which = part->options.part;
    if (which.count != count || seen[which.index]) return wrong("is of another comparison, or there twice");
    seen[which.index] = true;
    parts[which.index] = std::move(*part);
  }
  return parts;
}

}  // namespace

Options options_of_part(const Request& request, unsigned index) {
  Options options = request.options;
  options.part = {index, request.shards};
  // All work items that there are; each part has at least one.
  if (options.max_work_items != std::numeric_limits<std::uint64_t>::max()) {
    const std::uint64_t share = options.max_work_items / request.shards;
    options.max_work_items = std::max<std::uint64_t>(share + (index < options.max_work_items % request.shards), 1);
  }
  return options;
}

std::string to_part_json(const Comparison& part) {
  const Outcome& outcome = part.outcome;
  const Json json{
      {"part", {{"index", part.options.part.index}, {"count", part.options.part.count}}},
      {"partition", kPartition},
      {"version", version()},
      {"stop", name_of(kStops, outcome.stop)},
      {"a_to_b", json_of(outcome.a_to_b)},
      {"b_to_a", json_of(outcome.b_to_a)},
      {"precision_floor", outcome.precision_floor},
      {"diagonal_a", outcome.diagonal_a},
      {"simd", outcome.simd},
      {"threads", outcome.threads},
      {"timings_ms", timings(part)},
      {"meshes", {{"a", json_of(part.a)}, {"b", json_of(part.b)}}},
  };
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Whatever is not as it would be written, be it a member more, another engine, a number cut off or a name unknown,
// shows when what was understood is written again.
Result<Comparison> read_part(std::string_view json) {
  JsonFilter filter;
  if (!nlohmann::json::sax_parse(json, &filter)) return wrong("is not JSON: " + filter.defect);
  try {
    Comparison part = part_of(Json::parse(json));
    if (to_part_json(part) != json) return wrong("is not as this version of the engine writes it");
    if (!makes_sense(part)) return wrong("has numbers that cannot be");
    return part;
  } catch (const nlohmann::json::exception&) {
    return wrong("lacks a member, or has one of a wrong type");
  }
}

Result<Comparison> merge_parts(std::span<const std::string> documents, const Request& request) {
  auto parts = read_all(documents, request.shards);
  if (!parts) return parts.error();
  if (const auto why = mismatch(*parts, request)) return wrong(*why);
  std::vector<Outcome> outcomes;
  Comparison whole = parts->front();
  for (const Comparison& part : *parts) {
    outcomes.push_back(part.outcome);
    for (const TimeField& time : kTimes) whole.times.*time.ms = std::max(whole.times.*time.ms, part.times.*time.ms);
  }
  whole.id = random_id();
  whole.options = request.options;
  whole.units = request.units;
  whole.shards = request.shards;
  whole.outcome = joined(outcomes, request.options);
  if (relies_on_lost(whole.outcome)) return wrong("relied on a lower bound that none of them has");
  return whole;
}

}  // namespace meshgauge::api
