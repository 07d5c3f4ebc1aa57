#include "api/result/json_of.h"

#include <cstddef>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/figures.h"
#include "api/options/gate.h"
#include "api/options/names.h"
#include "api/result/notes.h"

namespace meshgauge::api {
namespace {

Json of_witness(const std::optional<Witness>& witness) {
  if (!witness) return nullptr;
  return {{"point_a", json_of(witness->point_a)},
          {"triangle_a", witness->triangle_a},
          {"point_b", json_of(witness->point_b)},
          {"triangle_b", witness->triangle_b}};
}

Json of_culling(const Culling& culling) {
  return {{"triangles", culling.triangles}, {"survivors", culling.survivors}, {"rate", culling.rate()}};
}

Json of_work(const Work& work) {
  return {{"nearest_queries", work.nearest_queries},
          {"cache_hits", work.cache_hits},
          {"triangle_tests", work.triangle_tests},
          {"subdivisions", work.subdivisions},
          {"max_depth", work.max_depth},
          {"peak_heap", work.peak_heap}};
}

Json of_edges(const EdgeCount& edges) {
  return {{"count", edges.count}, {"first", edges.count > 0 ? json_of(edges.first) : Json(nullptr)}};
}

Json name_or_null(const auto& named) { return named ? Json(to_string(*named)) : Json(nullptr); }

Json mismatch(const ReadNotes& notes) {
  if (!notes.filename_says && !notes.media_type_says) return nullptr;
  return {{"file_name", name_or_null(notes.filename_says)}, {"media_type", name_or_null(notes.media_type_says)}};
}

// The verdict of a region that has a limit is that of its criterion.
Json measured(const RegionOutcome& found) {
  const auto directed = [](const std::optional<Bounds>& bounds) {
    return bounds ? api::json_of(*bounds) : Json(nullptr);
  };
  return {{"distance", interval(found.lower, found.upper)},
          {"status", name_of(kStops, found.stop)},
          {"empty", found.empty},
          {"precision_floor", found.precision_floor},
          {"a_to_b", directed(found.a_to_b)},
          {"b_to_a", directed(found.b_to_a)},
          {"verdict", nullptr}};
}

Json of_interval(const AreaInterval& found) { return interval(found.lower, found.upper); }

Json of_direction(const std::optional<AreaBounds>& found, const AreaOptions& asked) {
  if (!found) return nullptr;
  Json json{{"status", name_of(kAreaStops, found->stop)}, {"pieces", found->pieces}};
  Json beyond = Json::array(), quantiles = Json::array();
  for (std::size_t k = 0; k < found->beyond.size(); ++k) {
    beyond.push_back({{"distance", asked.beyond[k].distance}, {"share", of_interval(found->beyond[k])}});
  }
  for (std::size_t q = 0; q < found->quantiles.size(); ++q) {
    quantiles.push_back({{"share", asked.quantiles[q]}, {"distance", of_interval(found->quantiles[q])}});
  }
  json["beyond"] = std::move(beyond);
  json["quantiles"] = std::move(quantiles);
  json["mean"] = found->mean ? of_interval(*found->mean) : Json(nullptr);
  json["rms"] = found->rms ? of_interval(*found->rms) : Json(nullptr);
  return json;
}

Json of_side(const SideBounds& found) {
  Json json = of_interval({found.lower, found.upper});
  json["point_a"] = found.at ? json_of(*found.at) : Json(nullptr);
  json["triangle_a"] = found.at ? Json(found.triangle) : Json(nullptr);
  return json;
}

}  // namespace

Json interval(double lower, double upper) { return {{"lower", lower}, {"upper", upper}}; }

Json json_of(const Bounds& bounds) {
  Json json = interval(bounds.lower, bounds.upper);
  json["witness"] = of_witness(bounds.witness);
  return json;
}

Json json_of(const std::optional<Directed>& directed) {
  if (!directed) return nullptr;
  Json json = json_of(directed->bounds);
  json["culling"] = of_culling(directed->culling);
  json["work"] = of_work(directed->work);
  return json;
}

Json json_of(const KnownUnit& known) {
  return {{"name", name_or_null(known.unit)}, {"source", to_string(known.source)}};
}

Json json_of(const MeshFacts& facts, const KnownUnit& unit) {
  return {{"format", to_string(facts.format)},
          {"format_mismatch", mismatch(facts.notes)},
          {"unit", json_of(unit)},
          {"bytes", facts.bytes},
          {"sha256", text_or_null(facts.sha256)},
          {"vertices", facts.vertices},
          {"triangles", facts.triangles},
          {"degenerate", facts.degenerate},
          {"bbox", {{"low", json_of(facts.bbox.low)}, {"high", json_of(facts.bbox.high)}}},
          {"diagonal", facts.diagonal},
          {"gzip", facts.notes.gzip},
          {"polygons",
           {{"count", facts.notes.polygons.count},
            {"concave", facts.notes.polygons.concave},
            {"non_planar", facts.notes.polygons.non_planar},
            {"self_crossing", facts.notes.polygons.self_crossing},
            {"largest_deviation", facts.notes.polygons.largest_deviation}}},
          {"skipped_primitives", facts.notes.skipped_primitives},
          {"unused_objects", facts.notes.unused_objects},
          {"helper_objects", facts.notes.helper_objects},
          {"welded_vertices", facts.notes.welded_vertices},
          {"notes", notes_of(facts)}};
}

Json json_of(const std::optional<Topology>& topology) {
  if (!topology) return nullptr;
  const auto& volume = topology->volume;
  return {{"watertight", topology->watertight()},
          {"oriented", topology->oriented()},
          {"components", topology->components},
          {"euler_characteristic", topology->euler_characteristic},
          {"edges", topology->edges},
          {"open_edges", of_edges(topology->open)},
          {"non_manifold_edges", of_edges(topology->non_manifold)},
          {"flipped_edges", of_edges(topology->flipped)},
          {"volume", volume ? interval(volume->lower, volume->upper) : Json(nullptr)}};
}

Json meshes_of(const Comparison& comparison) {
  Json json{{"a", json_of(comparison.a, comparison.units.a)}, {"b", json_of(comparison.b, comparison.units.b)}};
  if (!comparison.options.topology) return json;
  json["a"]["topology"] = json_of(comparison.a.topology);
  json["b"]["topology"] = json_of(comparison.b.topology);
  return json;
}

Json regions_of(const Outcome& outcome, const ComparisonOptions& options) {
  Json all = Json::array();
  for (std::size_t i = 0; i < outcome.regions.size(); ++i) {
    Json json = i < options.regions.size() ? json_of(options.regions[i]) : Json{{"name", kRest}};
    if (const auto limit = limit_of_region(options, i)) json["max_distance"] = *limit;
    json.update(measured(outcome.regions[i]));
    all.push_back(std::move(json));
  }
  return all;
}

std::string in_words(const NoSides& refused, const std::optional<LengthUnit>& unit) {
  using Why = NoSides::Why;
  std::string at;
  if (const auto& p = refused.at) at = with_unit(in_words(*p), unit);
  switch (refused.why) {
    case Why::open:
      return "mesh b is open: an edge at " + at + " has one triangle";
    case Why::non_manifold:
      return "mesh b is not manifold: an edge at " + at + " has more than two triangles";
    case Why::flipped:
      return "mesh b is not oriented: two triangles at " + at + " face different ways";
    case Why::inside_out:
      return "mesh b is inside out: its triangles face inwards";
    case Why::no_volume:
      return "mesh b encloses no volume";
    default:
      return "mesh b has a part that is inside out: it faces inwards around " + at;
  }
}

Json json_of(const SideOutcome& sides, const std::optional<LengthUnit>& unit) {
  const auto& refused = sides.refused;
  Json why = nullptr;
  if (refused)
    why = {{"reason", name_of(kNoSides, refused->why)},
           {"detail", in_words(*refused, unit)},
           {"at", refused->at ? json_of(*refused->at) : Json(nullptr)}};
  return {{"certified", true},
          {"status", name_of(kAreaStops, sides.stop)},
          {"length_tolerance", sides.options.length_tolerance},
          {"pieces", sides.pieces},
          {"refused", std::move(why)},
          {"outside", refused ? Json(nullptr) : of_side(sides.outside)},
          {"inside", refused ? Json(nullptr) : of_side(sides.inside)}};
}

Json json_of(const AreaOutcome& areas) {
  return {{"certified", true},
          {"share_tolerance", areas.options.share_tolerance},
          {"length_tolerance", areas.options.length_tolerance},
          {"a_to_b", of_direction(areas.a_to_b, areas.options)},
          {"b_to_a", of_direction(areas.b_to_a, areas.options)}};
}

}  // namespace meshgauge::api
