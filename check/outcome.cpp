#include "check/outcome.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "api/base/figures.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/compare/compare.h"
#include "api/formats/detect.h"
#include "api/formats/format.h"
#include "api/options/request.h"
#include "check/text.h"
#include "engine/hausdorff.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;
using api::with_unit;

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
    api::replace_all(text, "mesh a", "the candidate");
    api::replace_all(text, "mesh b", "the baseline");
    notes.push_back(std::move(text));
  }
  return notes;
}

// The document as if only the rest had been measured.
Result<Json> rest_of(const Json& document, const api::ComparisonOptions& options) {
  const auto regions = document.find("regions");
  if (regions == document.end() || !regions->is_array() || regions->size() != options.regions.size() + 1 ||
      !regions->back().is_object())
    return no_comparison("it has not the regions");
  Json part = document;
  for (const char* member : {"distance", "status", "a_to_b", "b_to_a"}) {
    if (!regions->back().contains(member)) return no_comparison("a region has no " + std::string(member));
    part[member] = regions->back()[member];
  }
  return part;
}

// What the document says of the limit beside its criterion: an interval, or null for a mesh without sides.
const Json& interval_of(const Json& document, const Criterion& asked, std::size_t region) {
  if (asked.beyond) return document.at("share_beyond").at("share");
  if (!asked.side.empty()) return document.at("sides").at(asked.side);
  if (asked.region.empty()) return document.at("distance");
  const Json& all = document.at("regions");
  const Json& found = asked.is_of_region() ? all.at(region) : all.back();
  static const Json kNone;
  return found.at("name") == asked.region ? found.at("distance") : kNone;
}

// Whether the criterion has the interval that the rest of the document has.
bool agrees(const Json& document, const Criterion& found, std::size_t region) try {
  const Json& interval = interval_of(document, found, region);
  if (!found.refused.empty() || interval.is_null()) return !found.refused.empty() && interval.is_null();
  return interval.at("lower") == found.lower && api::upper_of(interval) == found.upper;
} catch (const Json::exception&) {
  return false;
}

// Behind the limits the document has the expectations.
Result<std::vector<Criterion>> criteria_from(const Json& document, const api::ComparisonOptions& options) {
  const auto found = document.find("criteria");
  if (found == document.end() || !found->is_array())
    return no_comparison("it has no criteria, since the service is older than this program: update the service");
  std::vector<Criterion> criteria = api::limits_asked(options);
  std::size_t region = 0;
  for (std::size_t i = 0; i < std::max(criteria.size(), found->size()); ++i) {
    const std::string name = "its criterion " + std::to_string(i + 1);
    if (i == found->size()) return no_comparison(name + " is missing: the " + criteria[i].name);
    auto criterion = api::read_criterion((*found)[i]);
    if (!criterion) return no_comparison(name + " is none: " + criterion.error().message);
    if (i >= criteria.size() && criterion->of == Criterion::Of::expectation) continue;
    if (i >= criteria.size()) return no_comparison(name + " was not asked for");
    if (!is_same_limit(criteria[i], *criterion)) return no_comparison(name + " is not the " + criteria[i].name);
    if (!agrees(document, *criterion, region)) return no_comparison(name + " contradicts the rest of the result");
    region += criterion->is_of_region() ? 1U : 0U;
    if (criterion->refused.starts_with("mesh b")) criterion->refused.replace(0, 6, "the baseline");
    criteria[i] = *std::move(criterion);
  }
  return criteria;
}

Witness witness_of(const Criterion::Place& at) {
  return {at.on_a, at.point, at.triangle, at.nearest.value_or(at.point), at.nearest_triangle};
}

// Whether something is known of every limit and every expectation.
bool bounded(const GateOutcome& outcome) {
  return outcome.measured && std::isfinite(outcome.measured->upper) &&
         std::ranges::all_of(outcome.criteria(), &Criterion::is_known);
}

Error no_faces(const Gate& gate, const std::string& has) {
  const std::string how = gate.manifest.empty() ? "--cloud" : "'cloud: true' in the manifest";
  return with_files({ErrorCode::empty_mesh,
                     "'a' has " + has + " and no faces; if it is a point cloud, declare it by " + how, "a", ""},
                    gate);
}

bool is_cloud(const Json& document, const std::string& mesh) {
  const Json::json_pointer triangles("/meshes/" + mesh + "/triangles");
  return document.contains(triangles) && document.at(triangles) == 0;
}

// Advice: what the reader of a report can do.

constexpr int kAdviceDigits = 6;

std::string seconds(std::chrono::milliseconds time) {
  return shortest(static_cast<double>(time.count()) / 1000) + " s";
}

std::string longer_timeout(const Gate& gate) {
  if (static_cast<double>(gate.request.timeout.count()) < api::kTimeoutMsRange.high)
    return "a longer timeout than " + seconds(gate.request.timeout);
  return "more threads or a faster machine, since its timeout is the longest there is";
}

// A point on the side whose limit is exceeded most; empty: it is of no side, or none is known.
std::string for_side(const GateOutcome& outcome) {
  const Criterion* place = api::foremost_place(outcome.measured->criteria);
  if (!place || place->side.empty()) return "";
  return "Look at " + with_unit(in_words(place->at->point), outcome.unit()) + " on triangle " +
         std::to_string(place->at->triangle) + " of the candidate: it is " +
         with_unit(to_digits_below(place->lower, kAdviceDigits), outcome.unit()) + " or more " + place->side +
         " of the baseline.";
}

std::string for_fail(const GateOutcome& outcome) {
  const Measured& measured = *outcome.measured;
  if (const std::string advice = for_side(outcome); !advice.empty()) return advice;
  const auto& witness = measured.witness;
  const std::string unit = outcome.unit();
  if (!witness) return "";
  return "Look at " + with_unit(in_words(witness->from), unit) + " on " + measured.place_of_witness() + " of the " +
         witness->from_mesh() + ": it is " + with_unit(to_digits_below(measured.reached, kAdviceDigits), unit) +
         " or more from the " + witness->to_mesh() + ", nearest to " + with_unit(in_words(witness->to), unit) +
         " on triangle " + std::to_string(witness->to_triangle) + "." +
         (witness->on_candidate ? "" : " The candidate lacks what the baseline has there, or has it elsewhere.");
}

// Returns the limits that the interval decides; empty: none.
std::string deciding_limit(const GateOutcome& outcome, const Criterion& criterion) {
  const Criterion shown = criterion.beyond ? api::in_percent(criterion) : criterion;
  const std::string unit = criterion.beyond ? "%" : outcome.unit();
  std::string text;
  const double u = criterion.margin();
  if (std::isfinite(shown.upper))
    text = "of at least " + with_unit(to_digits_above(shown.upper + u, kAdviceDigits), unit) + " (pass)";
  if (shown.lower > u)
    text += (text.empty() ? "below " : " or below ") +
            with_unit(to_digits_below(shown.lower - u, kAdviceDigits), unit) + " (fail)";
  if (text.empty()) return "";
  return (criterion.beyond ? "a share " : "a limit ") + text;
}

// Returns what would have let the work go on, by the reason why it stopped.
std::string more_effort(const Gate& gate, const std::string& status) {
  if (status == "timeout") return longer_timeout(gate);
  if (status == "cancelled") return "letting it run to its end";
  if (status == "converged") return "a smaller tolerance";
  if (status == "budget") return "more memory for the waiting pieces";
  return "";
}

// Whether the interval lies between the ends of the limit: no narrower one decides.
bool is_open_for_ever(const Criterion& criterion) {
  const LimitEnds ends = criterion.ends();
  return criterion.lower > ends.pass && criterion.upper <= ends.fail;
}

std::string for_undecided(const GateOutcome& outcome, const Criterion& criterion) {
  if (!criterion.refused.empty())
    return "Close the baseline and let its triangles face outwards, or leave the zone out.";
  if (criterion.status == "no_area") return "A mesh has no area: all its triangles are degenerate.";
  if (criterion.beyond && criterion.status == "precision_floor")
    return "Decided by another distance than " + with_unit(shortest(*criterion.beyond), outcome.unit()) +
           ": part of the area is that far away, within rounding error.";
  const std::string limit = deciding_limit(outcome, criterion),
                    effort = is_open_for_ever(criterion) ? "" : more_effort(outcome.gate, criterion.status);
  return (criterion.is_of_region() ? criterion.region + ": decided by " : "Decided by ") + limit +
         (limit.empty() || effort.empty() ? "" : "; or ") + (effort.empty() ? "; " + why_open(criterion) : effort) +
         ".";
}

std::string for_undecided(const GateOutcome& outcome) {
  std::string text, last;
  for (const Criterion& criterion : outcome.measured->criteria) {
    if (criterion.verdict != api::Verdict::undecided) continue;
    std::string advice = for_undecided(outcome, criterion);
    if (advice != last) text += (text.empty() ? "" : " ") + advice;
    last = std::move(advice);
  }
  return text;
}

std::string repair(const Gate& gate, const Error& error) {
  const std::string file = (error.part == "b" ? gate.baseline : gate.candidate).string();
  const auto says = [&](std::string_view words) { return error.message.find(words) != std::string::npos; };
  switch (error.code) {
    case ErrorCode::unsupported_format:
      if (says(api::kLfsPointer)) return "Check the repository out with Git LFS ('lfs: true' of actions/checkout).";
      if (says(api::kNoMesh)) return "Check the step that puts '" + file + "' there.";
      return "Export '" + file + "' as OBJ, STL, PLY, OFF, glTF, GLB or 3MF.";
    case ErrorCode::unreadable_mesh:
      if (error.where.ends_with("].uri")) return "Export '" + file + "' as one .glb.";
      [[fallthrough]];
    case ErrorCode::non_finite_vertex:
    case ErrorCode::index_out_of_range:
      return "Write '" + file + "' again: it is damaged, or its writer does not follow the format.";
    case ErrorCode::empty_mesh:
      if (says(api::kAskFor)) {
        return std::string("In a manifest: 'direction: ") +
               (error.part == "b" ? "baseline_to_candidate" : "candidate_to_baseline") + "'.";
      }
      return "Check the step that writes '" + file + "'.";
    case ErrorCode::coordinate_too_large:
      return "Write '" + file + "' in a larger unit.";
    case ErrorCode::too_large:
      return "Make '" + file + "' smaller.";
    case ErrorCode::invalid_request:
      return error.part == "a" || error.part == "b" ? "Check its path, its permissions and the step that writes it."
                                                    : "";
    default:
      return "";
  }
}

std::string for_error(const Gate& gate, const Error& error) {
  const std::string hint = error.part.empty() ? "" : repair(gate, error);
  return error.message + (hint.empty() ? "" : ". " + hint);
}

std::string place_of(const std::string& manifest, const Mistake& mistake) {
  if (manifest.empty()) return "meshgauge check";
  if (mistake.line == 0) return manifest;
  return manifest + ":" + std::to_string(mistake.line) + ":" + std::to_string(mistake.column);
}

}  // namespace

Verdict verdict_of(api::Verdict verdict) {
  if (verdict == api::Verdict::pass) return Verdict::pass;
  return verdict == api::Verdict::fail ? Verdict::fail : Verdict::undecided;
}

std::string_view to_string(Verdict verdict) { return api::name_of(kVerdicts, verdict); }

std::string_view to_string(Level level) {
  constexpr std::string_view kNames[] = {"ok", "warning", "failure"};
  return kNames[static_cast<std::size_t>(level)];
}

const Criterion* Measured::distance() const {
  const auto found = std::ranges::find_if(criteria, &Criterion::is_of_whole);
  return found == criteria.end() ? nullptr : &*found;
}

std::string Measured::place_of_witness() const {
  if (!witness) return "";
  return (is_cloud(document, witness->on_candidate ? "a" : "b") ? "point " : "triangle ") +
         std::to_string(witness->from_triangle);
}

Result<Measured> measured_from(Json document, const Gate& gate) {
  const api::ComparisonOptions options = options_in(gate, document);
  const auto rest = options.regions.empty() ? Result<Json>(Json()) : rest_of(document, options);
  if (!rest) return rest.error();
  const Json& of_limit = options.regions.empty() ? document : *rest;  // what max_distance limits
  const auto facts = api::result_facts(of_limit, api::Side::a);
  if (!facts) return facts.error();
  const auto status = of_limit.find("status");
  if (status == of_limit.end() || !status->is_string()) return no_comparison("it has no status");
  auto criteria = criteria_from(document, options);
  if (!criteria) return criteria.error();
  Measured measured;
  static_cast<api::ResultFacts&>(measured) = *facts;
  measured.criteria = *std::move(criteria);
  measured.notes = notes_of(document);
  measured.unread = unread_of(document);
  measured.status = status->get<std::string>();
  measured.verdict = verdict_of(*api::worst(measured.criteria));
  measured.reached = measured.lower;
  const Criterion* place = api::foremost_place(measured.criteria);
  if (measured.verdict != Verdict::pass && place && place->at->nearest) {
    measured.witness = witness_of(*place->at);
    measured.reached = place->lower;
  }
  measured.document = std::move(document);
  return measured;
}

std::optional<Error> undeclared_cloud(const Gate& gate, const Json& document) {
  if (gate.cloud || !is_cloud(document, "a")) return std::nullopt;
  const Json& candidate = document.at("meshes").at("a");
  if (candidate.value("format", Json()) == std::string(api::to_string(api::Format::xyz))) return std::nullopt;
  const Json points = candidate.value("vertices", Json());
  return no_faces(gate, points.is_number_integer() ? points.dump() + " points" : "points");
}

std::optional<Error> undeclared_cloud(const Gate& gate, const api::MeshFacts& candidate) {
  if (gate.cloud || candidate.triangles > 0 || candidate.format == api::Format::xyz) return std::nullopt;
  return no_faces(gate, std::to_string(candidate.vertices) + " points");
}

Verdict GateOutcome::verdict() const {
  if (!measured) return interrupted ? Verdict::undecided : Verdict::error;
  const Verdict of_mesh = verdict_of(api::worst(expectations).value_or(api::Verdict::pass));
  for (const Verdict worse : {Verdict::fail, Verdict::undecided}) {
    if (measured->verdict == worse || of_mesh == worse) return worse;
  }
  return Verdict::pass;
}

std::vector<Criterion> GateOutcome::criteria() const {
  std::vector<Criterion> all;
  if (measured) all = measured->criteria;
  all.insert(all.end(), expectations.begin(), expectations.end());
  return all;
}

std::string GateOutcome::unit() const {
  const auto& known =
      measured && measured->units.result.unit ? measured->units.result.unit : gate.request.options.units.limit;
  return std::string(api::to_string(known));
}

Level GateOutcome::level(Undecided rule) const {
  const Verdict is = verdict();
  if (is == Verdict::pass) return Level::ok;
  if (is == Verdict::error) return Level::failure;
  if (is == Verdict::undecided && !bounded(*this)) return Level::failure;
  const bool allowed = gate.warn_only || (is == Verdict::undecided && rule == Undecided::warn);
  return allowed ? Level::warning : Level::failure;
}

std::string GateOutcome::advice() const {
  switch (verdict()) {
    case Verdict::pass:
      return "";
    case Verdict::fail:
      if (measured->verdict != Verdict::fail) return "Repair the candidate, or change what the gate expects.";
      return for_fail(*this);
    case Verdict::undecided:
      if (measured && measured->verdict == Verdict::undecided) return for_undecided(*this);
      if (measured) return "Decided by " + longer_timeout(gate) + ", or by another expectation.";
      if (!error) return "Interrupted before anything was known: run it again.";
      return error->message + ": decided by " + longer_timeout(gate) + ".";
    case Verdict::error:
      return error ? for_error(gate, *error) : "";
  }
  return "";
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

Report mistaken(const std::string& manifest, const std::vector<Mistake>& mistakes) {
  Report report;
  report.version = version();
  std::set<std::string> taken;
  for (const Mistake& mistake : mistakes) {
    GateOutcome outcome;
    const std::string place = place_of(manifest, mistake);
    outcome.gate.name = place;
    for (int i = 2; !taken.insert(outcome.gate.name).second; ++i) {
      outcome.gate.name = place + " (" + std::to_string(i) + ")";
    }
    outcome.gate.manifest = manifest;
    outcome.gate.line = mistake.line;
    outcome.error = refused(mistake.message);
    report.outcomes.push_back(std::move(outcome));
  }
  return report;
}

}  // namespace meshgauge::check
