#include "check/reports/history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/json_of.h"
#include "api/refused.h"
#include "api/with_unit.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using api::Json;
using api::text_or_null;

constexpr std::size_t kShownRuns = 30;
constexpr std::array kVerdicts{Verdict::pass, Verdict::fail, Verdict::undecided, Verdict::error};

Error no_history(const std::filesystem::path& file, const std::string& why) {
  return bad_flag("--history", "'" + file.string() + "' " + why);
}

std::optional<double> length(const Json& line, const char* name) {
  const auto found = line.find(name);
  return found != line.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

std::string text(const Json& line, const char* name) {
  const auto found = line.find(name);
  return found != line.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<PastShare> share_of(const Json& line) {
  const auto found = line.find("share_beyond");
  if (found == line.end() || !found->is_object()) return std::nullopt;
  const auto number = [&](const char* name) { return length(*found, name).value_or(NAN); };
  const PastShare share{number("distance"), number("lower"), number("upper"), number("limit")};
  const bool is_known = std::isfinite(share.distance + share.lower + share.upper + share.limit);
  return is_known ? std::optional(share) : std::nullopt;
}

// The limits of the zone's sides, or of the regions, by name; what is none is left out.
std::map<std::string, PastLimit> limits_of(const Json& line, const char* of) {
  std::map<std::string, PastLimit> limits;
  const auto all = line.find(of);
  if (all == line.end() || !all->is_object()) return limits;
  for (const auto& [name, found] : all->items()) {
    if (!found.is_object() || !length(found, "limit")) continue;
    limits[name] = {length(found, "lower"), length(found, "upper"), *length(found, "limit")};
  }
  return limits;
}

std::optional<PastLimit> limit_of(const std::map<std::string, PastLimit>& limits, const std::string& name) {
  const auto found = limits.find(name);
  return found != limits.end() ? std::optional(found->second) : std::nullopt;
}

// Returns the run and the gate's name; nullopt: the line is no result.
std::optional<std::pair<std::string, PastRun>> run_of(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || text(json, "gate").empty()) return std::nullopt;
  const std::string name = text(json, "verdict");
  const auto* verdict =
      std::find_if(kVerdicts.begin(), kVerdicts.end(), [&](Verdict v) { return to_string(v) == name; });
  if (verdict == kVerdicts.end()) return std::nullopt;
  const auto zone = limits_of(json, "zone");
  return std::pair(text(json, "gate"), PastRun{text(json, "commit"), *verdict, length(json, "lower"),
                                               length(json, "upper"), length(json, "limit"), text(json, "unit"),
                                               share_of(json), limit_of(zone, "inside"), limit_of(zone, "outside"),
                                               length(json, "uncertainty").value_or(0), limits_of(json, "regions")});
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const PastShare& share) {
  return {{"distance", share.distance}, {"limit", share.limit}, {"lower", share.lower}, {"upper", share.upper}};
}

Json json_of(const GateOutcome& outcome, const PastRun& run, const std::string& time) {
  Json json{{"time", time},
            {"commit", text_or_null(run.commit)},
            {"gate", outcome.gate.name},
            {"verdict", to_string(run.verdict)},
            {"lower", or_null(run.lower)},
            {"upper", or_null(run.upper)},
            {"limit", or_null(run.limit)},
            {"unit", text_or_null(run.unit)}};
  if (run.share_beyond) json["share_beyond"] = json_of(*run.share_beyond);
  if (run.inside && run.outside) json["zone"] = {{"inside", json_of(*run.inside)}, {"outside", json_of(*run.outside)}};
  if (run.uncertainty > 0) json["uncertainty"] = run.uncertainty;
  if (!run.regions.empty()) json["regions"] = json_of(run.regions);
  return json;
}

PastLimit past_of(const Criterion& found) {
  PastLimit past{{}, {}, found.limit};
  if (found.refused.empty()) past.lower = found.lower;
  if (std::isfinite(found.upper)) past.upper = found.upper;
  return past;
}

void add(const Criterion& criterion, PastRun& run) {
  if (criterion.beyond) {
    run.share_beyond = {*criterion.beyond, criterion.lower, criterion.upper, criterion.limit};
  } else if (criterion.is_of_region()) {
    run.regions[criterion.region] = past_of(criterion);
  } else if (criterion.side.empty()) {
    run.limit = criterion.limit;
  } else {
    (criterion.side == "inside" ? run.inside : run.outside) = past_of(criterion);
  }
}

PastRun run_of(const GateOutcome& outcome, const std::string& commit) {
  PastRun run{commit, outcome.verdict(), {}, {}, {}, outcome.unit()};
  if (!outcome.measured) return run;
  run.lower = outcome.measured->lower;
  if (std::isfinite(outcome.measured->upper)) run.upper = outcome.measured->upper;
  for (const Criterion& criterion : outcome.measured->criteria) add(criterion, run);
  run.uncertainty = outcome.measured->criteria.front().uncertainty;
  return run;
}

// Returns the run of one limit of several: `lower`, `upper` and `limit` of it, and their verdict.
PastRun run_of(PastRun run, std::optional<double> lower, std::optional<double> upper, std::optional<double> limit) {
  run.lower = lower;
  run.upper = upper;
  run.limit = limit;
  if (lower && limit) run.verdict = verdict_of(*lower, upper.value_or(INFINITY), *limit, run.uncertainty);
  return run;
}

PastRun area_run(PastRun run) {
  const auto share = std::exchange(run.share_beyond, std::nullopt);
  run.unit = "%";
  run.uncertainty = 0;
  if (!share) return run_of(std::move(run), {}, {}, {});
  return run_of(std::move(run), 100 * share->lower, 100 * share->upper, 100 * share->limit);
}

PastRun run_of(PastRun run, const std::optional<PastLimit>& of) {
  if (!of) return run_of(std::move(run), {}, {}, {});
  return run_of(std::move(run), of->lower, of->upper, of->limit);
}

void add(std::vector<PastRun>& runs, PastRun run) {
  runs.push_back(std::move(run));
  if (runs.size() > kShownRuns) runs.erase(runs.begin());
}

}  // namespace

Result<History> History::open(const std::filesystem::path& file) {
  History history;
  history.file_ = file;
  std::error_code failed;
  if (!std::filesystem::exists(file, failed)) return history;
  std::ifstream in(file);
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (line.empty()) continue;
    auto run = run_of(line);
    if (!run) return no_history(file, "line " + std::to_string(number) + " is no result of a gate: remove the line");
    add(history.runs_[run->first], std::move(run->second));
  }
  if (!in.eof()) return no_history(file, "cannot be read");
  return history;
}

Result<Done> History::keep(const std::string& time, const std::string& commit, Report& report) {
  std::string lines;
  for (GateOutcome& outcome : report.outcomes) {
    std::vector<PastRun>& runs = runs_[outcome.gate.name];
    add(runs, run_of(outcome, commit));
    lines += json_of(outcome, runs.back(), time).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    outcome.history = runs;
  }
  std::ofstream out(file_, std::ios::app);
  out << lines << std::flush;
  return out ? Result<Done>(Done{}) : no_history(file_, "cannot be written");
}

Json json_of(const PastLimit& past) {
  return {{"lower", or_null(past.lower)}, {"upper", or_null(past.upper)}, {"limit", past.limit}};
}

Json json_of(const std::map<std::string, PastLimit>& regions) {
  Json json = Json::object();
  for (const auto& [name, past] : regions) json[name] = json_of(past);
  return json;
}

std::string commit_of_pipeline() {
  for (const char* name : {"MESHGAUGE_COMMIT", "GITHUB_SHA", "CI_COMMIT_SHA", "GIT_COMMIT"}) {
    const char* value = std::getenv(name);
    if (value && *value) return value;
  }
  return "";
}

std::vector<Chart> charts_of(const GateOutcome& outcome) {
  std::vector<Chart> charts;
  const auto add = [&](std::string what, const std::string& unit, const auto& run_of_limit) {
    Chart& chart = charts.emplace_back(Chart{std::move(what), unit, {}});
    for (const PastRun& run : outcome.history) chart.runs.push_back(run_of_limit(run));
  };
  const auto whole = [](const PastRun& run) { return run_of(run, run.lower, run.upper, run.limit); };
  if (!outcome.measured) add("the distance", outcome.unit(), whole);
  for (const Criterion& c : outcome.measured ? outcome.measured->criteria : std::vector<Criterion>()) {
    if (c.beyond) {
      add("the area farther than " + api::with_unit(to_digits(*c.beyond, 6), outcome.unit()), "%", area_run);
    } else if (c.is_of_region()) {
      add("the " + c.name, outcome.unit(),
          [&](const PastRun& run) { return run_of(run, limit_of(run.regions, c.region)); });
    } else if (c.side.empty()) {
      add("the " + c.name, outcome.unit(), whole);
    } else {
      add("the " + c.name, outcome.unit(),
          [&](const PastRun& run) { return run_of(run, c.side == "inside" ? run.inside : run.outside); });
    }
  }
  return charts;
}

std::string uncertainty_of(const PastRun& run, const std::string& unit) {
  return run.uncertainty > 0 ? " ± " + api::with_unit(to_digits(run.uncertainty, 6), unit) : "";
}

std::string sparkline(const std::vector<PastRun>& runs) {
  constexpr std::array kHeights{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  constexpr double kLimitHeight = 4.5;
  if (runs.size() < 2) return "";
  std::string line;
  for (const PastRun& run : runs) {
    if (!run.limit || !run.lower) {
      line += "·";
      continue;
    }
    const double share = run.upper && *run.limit > 0 ? *run.upper / *run.limit : run.verdict == Verdict::pass ? 0 : 2;
    line += kHeights[static_cast<std::size_t>(std::clamp(share * kLimitHeight, 0.0, 7.0))];
  }
  return line;
}

}  // namespace meshgauge::check
