#include "check/outcome.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "api/unit_document.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

// By at(): what is missing or of another type throws, and is caught in measured_from().
Vec3 point(const Json& json) { return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()}; }

Witness witness(const Json& json, bool on_candidate) {
  return {on_candidate, point(json.at("point_a")), json.at("triangle_a").get<std::uint32_t>(),
          point(json.at("point_b")), json.at("triangle_b").get<std::uint32_t>()};
}

// Of the direction that attains `lower`: in a symmetric measurement the one that reaches further.
std::optional<Witness> best_witness(const Json& document) {
  std::optional<Witness> best;
  double reached = -1;
  for (const char* name : {"a_to_b", "b_to_a"}) {
    const Json& directed = document.at(name);
    if (directed.is_null() || directed.at("witness").is_null()) continue;
    const auto lower = directed.at("lower").get<double>();
    if (lower <= reached) continue;
    reached = lower;
    best = witness(directed.at("witness"), name[0] == 'a');
  }
  return best;
}

Error no_comparison(const std::string& why) {
  return {ErrorCode::internal, "the result is not that of a comparison: " + why, "", ""};
}

// Whoever measured: from nothing else may come a verdict. Also false of NaN.
bool is_interval(double lower, double upper) { return std::isfinite(lower) && lower >= 0 && lower <= upper; }

Verdict verdict_of(double lower, double upper, double limit) {
  if (upper <= limit) return Verdict::pass;
  return lower > limit ? Verdict::fail : Verdict::undecided;
}

// "mesh a" and "mesh b" are the candidate and the baseline here. A service may say anything.
std::vector<std::string> notes_of(const Json& document) {
  constexpr std::size_t kMost = 16, kMostBytes = 512;
  std::vector<std::string> notes;
  const auto found = document.find("notes");
  if (found == document.end() || !found->is_array()) return notes;
  for (const Json& note : *found) {
    if (!note.is_string() || notes.size() == kMost) continue;
    std::string text = note.get<std::string>().substr(0, kMostBytes);
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

bool bounded(const GateOutcome& outcome) { return outcome.measured && std::isfinite(outcome.measured->upper); }

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::undecided:
      return "undecided";
    case Verdict::error:
      return "error";
  }
  return "";
}

std::string_view to_string(Level level) {
  switch (level) {
    case Level::ok:
      return "ok";
    case Level::warning:
      return "warning";
    case Level::failure:
      return "failure";
  }
  return "";
}

Result<Measured> measured_from(Json document, double limit) try {
  Measured measured;
  measured.limit = limit;
  measured.lower = document.at("distance").at("lower").get<double>();
  const Json& upper = document.at("distance").at("upper");  // null: ended before there was one
  measured.upper = upper.is_null() ? std::numeric_limits<double>::infinity() : upper.get<double>();
  if (!is_interval(measured.lower, measured.upper)) return no_comparison("its distance is no interval");
  measured.status = document.at("status").get<std::string>();
  measured.verdict = verdict_of(measured.lower, measured.upper, limit);
  measured.witness = best_witness(document);
  measured.units = api::unit_plan_of(document);
  measured.notes = notes_of(document);
  measured.document = std::move(document);
  return measured;
} catch (const Json::exception& error) {
  return no_comparison(error.what());
}

Verdict GateOutcome::verdict() const {
  if (measured) return measured->verdict;
  return interrupted ? Verdict::undecided : Verdict::error;
}

std::string GateOutcome::unit() const {
  const auto& known = measured && measured->units.result.unit ? measured->units.result.unit : gate.limit.unit;
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
