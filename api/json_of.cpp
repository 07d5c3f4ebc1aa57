#include "api/json_of.h"

#include <string_view>

#include <nlohmann/json.hpp>

#include "api/notes.h"

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

}  // namespace

Json gate_of(const ComparisonOptions& options) {
  if (!has_limit(options)) return nullptr;
  Json json{{"max_distance", options.max_distance ? Json(*options.max_distance) : Json(nullptr)}};
  if (options.max_share_beyond) json["max_share_beyond"] = json_of(*options.max_share_beyond);
  if (options.zone) json["zone"] = json_of(*options.zone);
  if (options.uncertainty > 0) json["uncertainty"] = options.uncertainty;
  json["units"] = text_or_null(limit_unit_name(options.units));
  return json;
}

Json json_of(const ShareLimit& limit) { return {{"distance", limit.distance}, {"share", limit.share}}; }

Json json_of(const SideOptions::Zone& zone) { return {0 - zone.inside, zone.outside}; }

Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

Json json_of(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

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

Json json_of(const Tolerance& asked) {
  Json json = Json::object();
  if (asked.absolute) json["absolute"] = *asked.absolute;
  if (asked.diagonal) json["diagonal"] = *asked.diagonal;
  if (asked.relative) json["relative"] = *asked.relative;
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

}  // namespace meshgauge::api
