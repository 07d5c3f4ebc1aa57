#include "check/outcome.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "api/formats/format.h"
#include "api/region_json.h"
#include "check/mesh_names.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

Error no_comparison(const std::string& why) {
  return {ErrorCode::internal, "the result is not that of a comparison: " + why, "", ""};
}

// Number and size of the notes are limited, since a service is untrusted.
constexpr std::size_t kMostNotes = 16, kMostNoteBytes = 512;

// Returns what was not read of the surfaces. Other notes on one mesh stand in the document alone.
std::vector<std::string> unread_of(const Json& document) {
  std::vector<std::string> notes;
  for (const auto& [at, role] :
       {std::pair("/meshes/a/notes", "the candidate"), std::pair("/meshes/b/notes", "the baseline")}) {
    const Json::json_pointer place(at);
    if (!document.contains(place) || !document[place].is_array()) continue;
    std::size_t count = 0;
    for (const Json& note : document[place]) {
      if (!note.is_string() || !note.get_ref<const std::string&>().starts_with(api::Unread::kRemark) ||
          count++ >= kMostNotes)
        continue;
      notes.push_back(std::string(role) + ": " + note.get<std::string>().substr(0, kMostNoteBytes));
    }
  }
  return notes;
}

// Replaces "mesh a" and "mesh b".
std::vector<std::string> notes_of(const Json& document) {
  std::vector<std::string> notes;
  const auto found = document.find("notes");
  if (found == document.end() || !found->is_array()) return notes;
  for (const Json& note : *found) {
    if (!note.is_string() || notes.size() == kMostNotes) continue;
    std::string text = note.get<std::string>().substr(0, kMostNoteBytes);
    for (const auto& [mesh, role] : {std::pair("mesh a", "the candidate"), std::pair("mesh b", "the baseline")}) {
      const std::string_view from = mesh, to = role;
      for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
        text.replace(at, from.size(), to);
      }
    }
    notes.push_back(std::move(text));
  }
  return notes;
}

// Why the work on the areas ended: that of the first direction whose work did not end by itself.
std::string area_status(const Json& document) {
  for (const char* name : {"/areas/a_to_b/status", "/areas/b_to_a/status"}) {
    const Json::json_pointer at(name);
    if (document.contains(at) && document[at].is_string() && document[at] != "complete") return document[at];
  }
  return "complete";
}

std::optional<ShareBeyond> share_from(const Json& document, const api::ShareLimit& limit) {
  const Json::json_pointer lower("/share_beyond/share/lower"), upper("/share_beyond/share/upper");
  if (!document.contains(lower) || !document.contains(upper)) return std::nullopt;
  if (!document[lower].is_number() || !document[upper].is_number()) return std::nullopt;
  ShareBeyond share{limit, document[lower], document[upper], area_status(document)};
  const bool is_interval = share.lower >= 0 && share.lower <= share.upper && share.upper <= 1;
  return is_interval ? std::optional(std::move(share)) : std::nullopt;
}

ZoneReached::Side side_from(const Json& sides, const char* name, double limit) {
  ZoneReached::Side side{limit, 0, std::numeric_limits<double>::infinity(), {}, 0};
  const Json& found = sides.at(name);
  if (found.is_null()) return side;
  side.lower = found.at("lower").get<double>();
  side.upper = api::upper_of(found);
  if (const Json& p = found.at("point_a"); !p.is_null()) {
    side.at = Vec3(p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>());
    side.triangle = found.at("triangle_a").get<std::uint32_t>();
  }
  return side;
}

// nullopt: the document has no valid sides.
std::optional<ZoneReached> zone_from(const Json& document, const SideOptions::Zone& limit) try {
  const Json& sides = document.at("sides");
  ZoneReached zone{side_from(sides, "inside", limit.inside), side_from(sides, "outside", limit.outside),
                   api::sides_refused(sides), sides.at("status").get<std::string>()};
  const auto is_interval = [](const auto& side) { return side.lower >= 0 && side.lower <= side.upper; };
  return is_interval(zone.inside) && is_interval(zone.outside) ? std::optional(std::move(zone)) : std::nullopt;
} catch (const Json::exception&) {
  return std::nullopt;
}

Verdict worst(const std::vector<Criterion>& criteria) {
  const auto is = [](Verdict verdict) { return [=](const Criterion& c) { return c.verdict == verdict; }; };
  if (std::any_of(criteria.begin(), criteria.end(), is(Verdict::fail))) return Verdict::fail;
  return std::all_of(criteria.begin(), criteria.end(), is(Verdict::pass)) ? Verdict::pass : Verdict::undecided;
}

// In percent; rounded outwards, but for ends that are exact.
Criterion criterion_of(const ShareBeyond& share, double uncertainty) {
  const double lower = 100 * share.lower, upper = 100 * share.upper;
  return {share.limit.distance,
          uncertainty,
          100 * share.limit.share,
          share.lower > 0 ? std::nextafter(lower, 0.0) : 0,
          share.upper > 0 && share.upper < 1 ? std::nextafter(upper, 100.0) : upper,
          share.status,
          verdict_of(share.lower, share.upper, share.limit.share)};
}

// The document as if only one region had been measured, or behind them the rest.
Result<Json> part_of(const Json& document, const Limits& limits, std::size_t region) {
  const auto regions = document.find("regions");
  if (regions == document.end() || !regions->is_array() || regions->size() != limits.regions.size() + 1 ||
      !regions->at(region).is_object())
    return no_comparison("it has not the regions");
  const Json& found = regions->at(region);
  Json part = document;
  for (const char* member : {"distance", "status", "a_to_b", "b_to_a"}) {
    if (!found.contains(member)) return no_comparison("a region has no " + std::string(member));
    part[member] = found[member];
  }
  return part;
}

// The witness of the region that is farthest beyond its limit, when the rest keeps its own.
void look_at_failure(const Json& document, const Limits& limits, Measured& measured) {
  double most = 0;
  const auto& regions = measured.regions;
  if (regions.empty() || criteria_of(measured).front().verdict == Verdict::fail) return;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (regions[i].verdict != Verdict::fail || regions[i].lower - regions[i].limit < most) continue;
    const auto part = part_of(document, limits, i);
    const auto facts = part ? api::result_facts(*part, api::Side::a) : Result<api::ResultFacts>(part.error());
    if (!facts || !facts->witness) continue;
    most = regions[i].lower - regions[i].limit;
    measured.witness = facts->witness;
    measured.reached = facts->lower;
  }
}

Result<Criterion> region_from(const Json& json, const Region& asked, const Limits& limits) try {
  if (json.at("name") != asked.name) return no_comparison("it has not the regions");
  const Json& distance = json.at("distance");
  Criterion found;
  found.region = asked.name;
  found.uncertainty = limits.uncertainty;
  found.limit = asked.max_distance ? *asked.max_distance : limits.max_distance.value_or(0);
  found.lower = distance.at("lower").get<double>();
  found.upper = api::upper_of(distance);
  if (!(found.lower >= 0 && found.lower <= found.upper)) return no_comparison("a region has no interval");
  found.status = json.at("status").get<std::string>();
  found.verdict = verdict_of(found.lower, found.upper, found.limit, found.uncertainty);
  return found;
} catch (const Json::exception& error) {
  return no_comparison(error.what());
}

void add_criteria(const ZoneReached& zone, double u, std::vector<Criterion>& criteria) {
  const auto add = [&](const ZoneReached::Side& side, std::string_view name) {
    const Verdict verdict =
        zone.refused.empty() ? verdict_of(side.lower, side.upper, side.limit, u) : Verdict::undecided;
    criteria.push_back({std::nullopt, u, side.limit, side.lower, side.upper, zone.status, verdict, {}, name});
  };
  if (zone.refused.empty()) add(zone.inside, "inside");
  add(zone.outside, "outside");
}

// Whether something is known of every limit and every expectation.
bool bounded(const GateOutcome& outcome) {
  if (!outcome.measured || !std::isfinite(outcome.measured->upper)) return false;
  const auto& share = outcome.measured->share_beyond;
  if (share && share->lower <= 0 && share->upper >= 1) return false;
  const auto& zone = outcome.measured->zone;
  if (zone && !(std::isfinite(zone->inside.upper) && std::isfinite(zone->outside.upper))) return false;
  return std::ranges::all_of(outcome.expectations, &Expectation::known);
}

bool is_cloud(const Json& document, const std::string& mesh) {
  const Json::json_pointer triangles("/meshes/" + mesh + "/triangles");
  return document.contains(triangles) && document.at(triangles) == 0;
}

}  // namespace

Verdict verdict_of(double lower, double upper, double limit, double uncertainty) {
  return verdict_of(api::verdict_within(lower, upper, limit, uncertainty));
}

Verdict verdict_of(api::Verdict found) {
  return found == api::Verdict::pass ? Verdict::pass : found == api::Verdict::fail ? Verdict::fail : Verdict::undecided;
}

std::string_view to_string(Verdict verdict) {
  constexpr std::string_view kNames[] = {"pass", "fail", "undecided", "error"};
  return kNames[static_cast<std::size_t>(verdict)];
}

std::string_view to_string(Level level) {
  constexpr std::string_view kNames[] = {"ok", "warning", "failure"};
  return kNames[static_cast<std::size_t>(level)];
}

api::ResultFacts facts_of(const Measured& measured) {
  return {measured.shown,
          measured.lower,
          measured.upper,
          measured.witness,
          measured.direction,
          measured.units,
          measured.motion,
          measured.zone.has_value(),
          measured.zone ? measured.zone->refused : ""};
}

std::vector<Criterion> criteria_of(const Measured& measured) {
  std::vector<Criterion> criteria;
  if (measured.has_max_distance)
    criteria.push_back({std::nullopt, measured.uncertainty, measured.limit, measured.lower, measured.upper,
                        measured.status,
                        verdict_of(measured.lower, measured.upper, measured.limit, measured.uncertainty),
                        measured.regions.empty() ? std::string() : std::string(api::kRest)});
  if (measured.zone) add_criteria(*measured.zone, measured.uncertainty, criteria);
  criteria.insert(criteria.end(), measured.regions.begin(), measured.regions.end());
  if (measured.share_beyond) criteria.push_back(criterion_of(*measured.share_beyond, measured.uncertainty));
  return criteria;
}

Criterion foremost(const Measured& measured) {
  const std::vector<Criterion> criteria = criteria_of(measured);
  const auto rank = [&](const Criterion& c) {
    const double limit = std::max(c.limit, std::numeric_limits<double>::min());
    return std::pair(c.verdict == measured.verdict, c.upper / limit);
  };
  return *std::max_element(criteria.begin(), criteria.end(),
                           [&](const Criterion& a, const Criterion& b) { return rank(a) < rank(b); });
}

std::string Criterion::distance_name() const {
  if (!side.empty()) return "distance " + std::string(side);
  if (region.empty()) return "distance";
  return region == api::kRest ? "distance in no region" : "distance in " + region;
}

std::string Measured::place_of_witness() const {
  if (!witness) return "";
  return (is_cloud(document, witness->on_candidate ? "a" : "b") ? "point " : "triangle ") +
         std::to_string(witness->from_triangle);
}

Result<Measured> measured_from(Json document, const Limits& limits) {
  const auto rest = limits.regions.empty() ? Result<Json>(Json()) : part_of(document, limits, limits.regions.size());
  if (!rest) return rest.error();
  const Json& of_limit = limits.regions.empty() ? document : *rest;  // what max_distance limits
  const auto facts = api::result_facts(of_limit, api::Side::a);
  if (!facts) return facts.error();
  const auto status = of_limit.find("status");
  if (status == of_limit.end() || !status->is_string()) return no_comparison("it has no status");
  Measured measured;
  measured.has_max_distance = limits.max_distance.has_value();
  measured.uncertainty = limits.uncertainty;
  if (limits.max_share_beyond) {
    measured.share_beyond = share_from(document, *limits.max_share_beyond);
    if (!measured.share_beyond) return no_comparison("it has no share of the area beyond the limit");
  }
  for (std::size_t i = 0; i < limits.regions.size(); ++i) {
    auto region = region_from(document["regions"][i], limits.regions[i], limits);
    if (!region) return region.error();
    measured.regions.push_back(*std::move(region));
  }
  if (limits.zone) {
    measured.zone = zone_from(document, *limits.zone);
    if (!measured.zone) return no_comparison("it does not say how far the candidate is on each side");
  }
  measured.limit = limits.max_distance.value_or(0);
  measured.shown = facts->limit.value_or(api::DistanceLimit{measured.limit});
  measured.lower = facts->lower;
  measured.upper = facts->upper;
  measured.units = facts->units;
  measured.motion = facts->motion;
  measured.notes = notes_of(document);
  measured.unread = unread_of(document);
  measured.status = status->get<std::string>();
  measured.verdict = worst(criteria_of(measured));
  measured.witness = facts->witness;
  look_at_failure(document, limits, measured);
  measured.direction = facts->direction;
  measured.document = std::move(document);
  return measured;
}

std::optional<Error> undeclared_cloud(const Gate& gate, const Json& document) {
  if (gate.cloud || !is_cloud(document, "a")) return std::nullopt;
  const Json& candidate = document.at("meshes").at("a");
  if (candidate.value("format", Json()) == std::string(api::to_string(api::Format::xyz))) return std::nullopt;
  const Json points = candidate.value("vertices", Json());
  const std::string count = points.is_number_integer() ? points.dump() + " points" : "points";
  const std::string how = gate.manifest.empty() ? "--cloud" : "'cloud: true' in the manifest";
  return with_files({ErrorCode::empty_mesh,
                     "'a' has " + count + " and no faces; if it is a point cloud, declare it by " + how, "a", ""},
                    gate);
}

Verdict GateOutcome::verdict() const {
  const auto is = [&](Verdict verdict) {
    return measured->verdict == verdict ||
           std::any_of(expectations.begin(), expectations.end(),
                       [&](const Expectation& e) { return verdict_of(e.verdict) == verdict; });
  };
  if (measured) return is(Verdict::fail) ? Verdict::fail : is(Verdict::undecided) ? Verdict::undecided : Verdict::pass;
  return interrupted ? Verdict::undecided : Verdict::error;
}

std::string GateOutcome::unit() const {
  const auto& known = measured && measured->units.result.unit ? measured->units.result.unit : main_limit(gate).unit;
  return known ? std::string(api::to_string(*known)) : std::string();
}

Level GateOutcome::level(Undecided rule) const {
  const Verdict is = verdict();
  if (is == Verdict::pass) return Level::ok;
  if (is == Verdict::error) return Level::failure;
  if (is == Verdict::undecided && !bounded(*this)) return Level::failure;
  const bool allowed = gate.warn_only || (is == Verdict::undecided && rule == Undecided::warn);
  return allowed ? Level::warning : Level::failure;
}

std::size_t Report::count(Verdict verdict) const {
  return static_cast<std::size_t>(
      std::count_if(outcomes.begin(), outcomes.end(), [&](const GateOutcome& o) { return o.verdict() == verdict; }));
}

int Report::exit_code() const {
  bool fail = false, open = interrupted;
  for (const GateOutcome& outcome : outcomes) {
    if (outcome.level(undecided) != Level::failure) continue;
    const Verdict is = outcome.verdict();
    if (is == Verdict::error) return 3;
    (is == Verdict::fail || undecided == Undecided::fail ? fail : open) = true;
  }
  if (fail) return 1;
  return open ? 2 : 0;
}

}  // namespace meshgauge::check
