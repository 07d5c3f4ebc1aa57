#include "check/reports/earlier.h"

#include <algorithm>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/whole_file.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

using ReportJson = nlohmann::ordered_json;

constexpr double kNotable = 0.01;  // a share of the limit

// Members that changes do not need; the first one is most of a report.
bool is_left_out(std::string_view member) { return member == "comparison" || member == "history"; }

Result<ReportJson> report_json(const std::filesystem::path& file) {
  const auto whole = api::WholeFile::open(file.string());
  if (!whole) return whole.error();
  const auto is_wanted = [](int, ReportJson::parse_event_t event, ReportJson& value) {
    return event != ReportJson::parse_event_t::key || !is_left_out(value.get_ref<const std::string&>());
  };
  ReportJson json = ReportJson::parse(api::as_text(whole->bytes()), is_wanted, false);
  const bool is_report = json.is_object() && json.contains("gates") && json["gates"].is_array();
  if (!is_report) return refused("'" + file.string() + "' is no report of check --json");
  return json;
}

// Empty: the member is missing or no text.
std::string text_in(const ReportJson& object, const char* member) {
  const auto found = object.find(member);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// Returns the gate and its name; nullopt: it is none.
std::optional<std::pair<std::string, EarlierGate>> gate_in(const ReportJson& json) {
  const auto verdict = api::value_of(kVerdicts, text_in(json, "verdict"));
  if (!verdict || text_in(json, "name").empty()) return std::nullopt;
  EarlierGate gate{*verdict};
  if (const auto limit = json.find("limit"); limit != json.end()) gate.unit = text_in(*limit, "units");
  gate.criteria = api::read_criteria(json);
  std::erase_if(gate.criteria, [](const Criterion& one) { return one.of == Criterion::Of::expectation; });
  return std::pair(text_in(json, "name"), std::move(gate));
}

const Criterion* foremost_of(std::span<const Criterion> limits) {
  return limits.empty() ? nullptr : &api::foremost(limits);
}

const Criterion* limit_named(std::span<const Criterion> limits, const std::string& name) {
  const auto found = std::ranges::find(limits, name, &Criterion::name);
  return found == limits.end() ? nullptr : &*found;
}

bool has_moved(const Criterion& now, const Criterion& before) {
  return std::max(now.lower - before.upper, before.lower - now.upper) > kNotable * now.limit;
}

std::string gate_in_words(Verdict verdict, const Criterion* shown, const std::string& unit) {
  std::string text(to_string(verdict));
  if (!shown) return text;
  return text + ", " + (shown->region.empty() ? "" : shown_name(shown->region) + ": ") +
         interval_in_words(*shown, unit);
}

std::span<const Criterion> measured_limits(const GateOutcome& outcome) {
  if (!outcome.measured) return {};
  return outcome.measured->criteria;
}

// nullopt: it is as it was.
std::optional<Change> change_of(const GateOutcome& outcome, const EarlierGate& before) {
  const std::span<const Criterion> limits = measured_limits(outcome);
  const Criterion* shown = foremost_of(limits);
  if (outcome.verdict() == before.verdict) {
    if (outcome.unit() != before.unit) return std::nullopt;
    const auto moved = std::ranges::find_if(limits, [&](const Criterion& now) {
      const Criterion* was = limit_named(before.criteria, now.name);
      return was && has_moved(now, *was);
    });
    if (moved == limits.end()) return std::nullopt;
    shown = &*moved;
  }
  const Criterion* was = shown ? limit_named(before.criteria, shown->name) : nullptr;
  if (!was) was = foremost_of(before.criteria);
  return Change{outcome.gate.name, gate_in_words(before.verdict, was, before.unit),
                gate_in_words(outcome.verdict(), shown, outcome.unit())};
}

}  // namespace

Earlier earlier_run(const std::filesystem::path& report) {
  Earlier earlier{report.stem().string()};
  const auto json = report_json(report);
  if (!json) {
    earlier.problem = json.error().message;
    return earlier;
  }
  for (const ReportJson& one : json->at("gates")) {
    if (auto gate = gate_in(one)) earlier.gates.insert(*std::move(gate));
  }
  return earlier;
}

std::vector<Change> changes_since(const Earlier& earlier, const Report& report) {
  std::vector<Change> changes;
  std::set<std::string_view> seen;
  for (const GateOutcome& outcome : report.outcomes) {
    seen.insert(outcome.gate.name);
    const auto before = earlier.gates.find(outcome.gate.name);
    if (before == earlier.gates.end()) {
      changes.push_back({outcome.gate.name, "",
                         gate_in_words(outcome.verdict(), foremost_of(measured_limits(outcome)), outcome.unit())});
    } else if (auto change = change_of(outcome, before->second)) {
      changes.push_back(*std::move(change));
    }
  }
  for (const auto& [name, gate] : earlier.gates) {
    if (!seen.contains(name))
      changes.push_back({name, gate_in_words(gate.verdict, foremost_of(gate.criteria), gate.unit), ""});
  }
  return changes;
}

}  // namespace meshgauge::check
