#include "check/reports/history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/figures.h"
#include "api/base/refused.h"
#include "api/result/json_of.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using api::Json;
using api::number_or_null;
using api::text_or_null;

constexpr std::size_t kShownRuns = 30;

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

// What is no criterion is left out.
std::map<std::string, PastCriterion> criteria_of(const Json& line) {
  std::map<std::string, PastCriterion> criteria;
  const auto all = line.find("criteria");
  if (all == line.end() || !all->is_array()) return criteria;
  for (const Json& found : *all) {
    if (!found.is_object() || text(found, "name").empty() || !length(found, "limit")) continue;
    criteria[text(found, "name")] = {length(found, "lower"), length(found, "upper"), *length(found, "limit")};
  }
  return criteria;
}

// Returns the run and the gate's name; nullopt: the line is no result.
std::optional<std::pair<std::string, PastRun>> run_of(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || text(json, "gate").empty()) return std::nullopt;
  const auto verdict = api::value_of(kVerdicts, text(json, "verdict"));
  if (!verdict) return std::nullopt;
  return std::pair(text(json, "gate"),
                   PastRun{text(json, "commit"), *verdict, length(json, "lower"), length(json, "upper"),
                           length(json, "limit"), text(json, "unit"), api::terms_in(json), criteria_of(json)});
}

Json json_of(const GateOutcome& outcome, const PastRun& run, const std::string& time) {
  Json json{{"time", time}, {"commit", nullptr}, {"gate", outcome.gate.name}};
  json.update(json_of(run));  // the commit keeps its place
  json.update(api::terms_json(run.terms));
  json["criteria"] = json_of(run.criteria);
  return json;
}

PastRun run_of(const GateOutcome& outcome, const std::string& commit) {
  PastRun run{commit, outcome.verdict(), {}, {}, {}, outcome.unit()};
  if (!outcome.measured) return run;
  const auto finite = [](double upper) { return std::isfinite(upper) ? std::optional(upper) : std::nullopt; };
  run.lower = outcome.measured->lower;
  run.upper = finite(outcome.measured->upper);
  for (const Criterion& c : outcome.measured->criteria) {
    run.criteria[c.name] = {c.refused.empty() ? std::optional(c.lower) : std::nullopt, finite(c.upper), c.limit};
    if (c.is_of_whole()) run.limit = c.limit;
  }
  run.terms = outcome.measured->criteria.front();
  return run;
}

// The run with the verdict of its own interval and limit.
PastRun judged(PastRun run) {
  if (run.lower && run.limit)
    run.verdict = verdict_of(api::verdict_within(*run.lower, run.upper.value_or(INFINITY), run.ends()));
  return run;
}

// The run of this criterion alone.
PastRun run_of(PastRun run, const Criterion& of) {
  const auto found = run.criteria.find(of.name);
  run.lower = run.upper = run.limit = std::nullopt;
  if (found == run.criteria.end()) return run;
  const double scale = of.beyond ? 100 : 1;
  const auto scaled = [&](std::optional<double> bound) { return bound ? std::optional(scale * *bound) : bound; };
  run.lower = scaled(found->second.lower);
  run.upper = scaled(found->second.upper);
  run.limit = scale * found->second.limit;
  if (of.beyond) run.terms = {};
  return judged(std::move(run));
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

Json json_of(const PastRun& run) {
  return {{"commit", text_or_null(run.commit)}, {"verdict", to_string(run.verdict)},
          {"lower", number_or_null(run.lower)}, {"upper", number_or_null(run.upper)},
          {"limit", number_or_null(run.limit)}, {"unit", text_or_null(run.unit)}};
}

Json json_of(const std::map<std::string, PastCriterion>& criteria) {
  Json json = Json::array();
  for (const auto& [name, past] : criteria) {
    json.push_back({{"name", name},
                    {"lower", number_or_null(past.lower)},
                    {"upper", number_or_null(past.upper)},
                    {"limit", past.limit}});
  }
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
  if (!outcome.measured) {
    Chart& chart = charts.emplace_back(Chart{"the distance", outcome.unit(), {}});
    for (const PastRun& run : outcome.history) chart.runs.push_back(judged(run));
    return charts;
  }
  for (const Criterion& c : outcome.measured->criteria) {
    Chart& chart = charts.emplace_back(Chart{"the " + c.name, outcome.unit(), {}});
    if (c.beyond) chart = {"the area farther than " + api::with_unit(to_digits(*c.beyond, 6), outcome.unit()), "%", {}};
    for (const PastRun& run : outcome.history) chart.runs.push_back(run_of(run, c));
  }
  return charts;
}

std::string margin_of(const Chart& chart) { return api::plus_minus(chart.runs.back().terms, chart.unit); }

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
