#include <chrono>
#include <cmath>
#include <string>

#include "api/compare.h"
#include "api/figures.h"
#include "api/formats/detect.h"
#include "api/request.h"
#include "api/with_unit.h"
#include "check/outcome.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using api::to_digits_above, api::to_digits_below, api::with_unit;

constexpr int kDigits = 6;

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
         with_unit(to_digits_below(place->lower, kDigits), outcome.unit()) + " or more " + place->side +
         " of the baseline.";
}

std::string for_fail(const GateOutcome& outcome) {
  const Measured& measured = *outcome.measured;
  if (const std::string advice = for_side(outcome); !advice.empty()) return advice;
  const auto& witness = measured.witness;
  const std::string unit = outcome.unit();
  if (!witness) return "";
  const std::string from = witness->on_candidate ? "candidate" : "baseline";
  const std::string to = witness->on_candidate ? "baseline" : "candidate";
  return "Look at " + with_unit(in_words(witness->from), unit) + " on " + measured.place_of_witness() + " of the " +
         from + ": it is " + with_unit(to_digits_below(measured.reached, kDigits), unit) + " or more from the " + to +
         ", nearest to " + with_unit(in_words(witness->to), unit) + " on triangle " +
         std::to_string(witness->to_triangle) + "." +
         (witness->on_candidate ? "" : " The candidate lacks what the baseline has there, or has it elsewhere.");
}

// Returns the limits that the interval decides; empty: none.
std::string deciding_limit(const GateOutcome& outcome, const Criterion& criterion) {
  const Criterion shown = criterion.beyond ? api::in_percent(criterion) : criterion;
  const std::string unit = criterion.beyond ? "%" : outcome.unit();
  std::string text;
  const double u = criterion.beyond ? 0 : criterion.uncertainty;
  if (std::isfinite(shown.upper))
    text = "of at least " + with_unit(to_digits_above(shown.upper + u, kDigits), unit) + " (pass)";
  if (shown.lower > u)
    text += (text.empty() ? "below " : " or below ") + with_unit(to_digits_below(shown.lower - u, kDigits), unit) +
            " (fail)";
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

// Whether the interval is within the limit less and plus the uncertainty: no narrower one decides.
bool is_open_for_ever(const Criterion& criterion) {
  const double u = criterion.beyond ? 0 : criterion.uncertainty;
  return criterion.lower > criterion.limit - u && criterion.upper <= criterion.limit + u;
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
  const std::string decided = (criterion.is_of_region() ? criterion.region + ": decided by " : "Decided by ") + limit +
                              (limit.empty() || effort.empty() ? "" : "; or ") + effort;
  if (!effort.empty()) return decided + ".";
  if (criterion.uncertainty > 0)
    return decided + "; the " + (criterion.beyond ? "share" : "distance") +
           " is closer to its limit than the uncertainty lets be told.";
  return decided + "; the limit is within rounding error of the " + (criterion.beyond ? "share." : "distance.");
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

}  // namespace

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

}  // namespace meshgauge::check
