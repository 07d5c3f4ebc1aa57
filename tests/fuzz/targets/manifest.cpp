// A manifest of gates. Asserted: what is said has a place in the file or is about all of it, and can be shown; what is
// accepted is in range; written anew it is read as the same. Files are not looked for: the globs and names of an
// accepted manifest are filled in for a name made up.
#include <algorithm>
#include <string>

#include <nlohmann/json.hpp>

#include "api/formats/utf8.h"
#include "api/names.h"
#include "api/request.h"
#include "check/manifest/glob.h"
#include "check/manifest/manifest_text.h"
#include "check/manifest/naming.h"
#include "check/manifest/quantities.h"
#include "check/manifest/yaml_tree.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using namespace check;
using Json = nlohmann::ordered_json;

std::string number(double x) { return Json(x).dump(); }

Json as_manifest(const Tolerance& tolerance) {
  Json json = Json::object();
  if (tolerance.absolute) json["absolute"] = *tolerance.absolute;
  if (tolerance.diagonal) json["diagonal"] = *tolerance.diagonal;
  if (tolerance.relative) json["relative"] = *tolerance.relative;
  return json;
}

// A share has been divided by a hundred, and is checked apart.
std::string as_manifest(const Limit& limit) {
  if (limit.max_diagonal_share) return "1 %";
  return number(limit.max_distance.value_or(0)) + (limit.unit ? " " + std::string(to_string(*limit.unit)) : "");
}

// JSON is YAML.
Json as_manifest(const Entry& entry) {
  const Gate& gate = entry.gate;
  Json json{{"name", entry.name.text},
            {"candidate", entry.candidate.text},
            {"baseline", entry.baseline.text},
            {"direction", name_of(api::kDirections, gate.options.direction)},
            {"timeout", std::to_string(gate.timeout.count()) + " ms"},
            {"strategy", name_of(api::kStrategies, gate.options.strategy)},
            {"tolerance", as_manifest(gate.options.tolerance)},
            {"statistics", gate.statistics},
            {"on_fail", gate.warn_only ? "warn" : "fail"}};
  if (gate.limit.is_given()) json["max_distance"] = as_manifest(gate.limit);
  if (gate.area_limit) {
    json["max_share_beyond"] = {{"distance", as_manifest(gate.area_limit->distance)}, {"share", "1 %"}};
  }
  if (gate.zone) json["zone"] = {"-" + as_manifest(gate.zone->inside), as_manifest(gate.zone->outside)};
  if (gate.options.strategy == Strategy::n_point) json["points"] = gate.options.points;
  if (gate.threads_given) json["threads"] = gate.options.threads;
  const api::AskedUnits& units = gate.options.units;
  if (units.a) json["units"]["candidate"] = to_string(*units.a);
  if (units.b) json["units"]["baseline"] = to_string(*units.b);
  return json;
}

bool same_entry(const Entry& x, const Entry& y) {
  const Options &a = x.gate.options, &b = y.gate.options;
  const bool same_limit = x.gate.limit.max_diagonal_share || (x.gate.limit.max_distance == y.gate.limit.max_distance &&
                                                              x.gate.limit.unit == y.gate.limit.unit);
  return same_limit && x.gate.options.units == y.gate.options.units && x.name.text == y.name.text &&
         x.candidate.text == y.candidate.text && x.baseline.text == y.baseline.text && a.direction == b.direction &&
         a.strategy == b.strategy && (a.strategy != Strategy::n_point || a.points == b.points) &&
         a.threads == b.threads && a.tolerance.absolute == b.tolerance.absolute &&
         a.tolerance.diagonal == b.tolerance.diagonal && a.tolerance.relative == b.tolerance.relative &&
         x.gate.timeout == y.gate.timeout && x.gate.threads_given == y.gate.threads_given &&
         x.gate.statistics == y.gate.statistics && x.gate.warn_only == y.gate.warn_only;
}

void require_sound(const Limit& limit) {
  require(limit.max_distance.has_value() != limit.max_diagonal_share.has_value(), "a limit is of one kind");
  const double value = limit.max_distance ? *limit.max_distance : *limit.max_diagonal_share;
  require(api::in_range(value, api::kMaxDistanceRange, "limit").ok(), "the limit is in range");
  require(!limit.unit || limit.max_distance, "a share has no unit");
}

void require_sound(const Entry& entry) {
  require(entry.gate.limit.is_given() || entry.gate.area_limit || entry.gate.zone, "a gate has a limit");
  if (entry.gate.zone) {
    require_sound(entry.gate.zone->inside);
    require_sound(entry.gate.zone->outside);
  }
  if (entry.gate.limit.is_given()) require_sound(entry.gate.limit);
  if (entry.gate.area_limit) {
    require_sound(entry.gate.area_limit->distance);
    require(entry.gate.area_limit->share >= 0 && entry.gate.area_limit->share <= 1, "the share is in range");
  }
  require(entry.gate.timeout.count() >= 1 && entry.gate.timeout.count() <= 180'000, "the time is in range");
  require(is_stencil(entry.gate.options.points), "the number of points is a stencil");
  require(api::in_range(entry.gate.options.threads, api::kThreadsRange, "threads").ok(), "the threads are in range");
  require(!entry.name.text.empty() && entry.name.text.size() <= kMaxNameBytes && is_utf8(entry.name.text),
          "the name is a text");
  require(check_glob(entry.candidate.text).ok() && check_template(entry.baseline.text).ok(), "patterns are checked");
  const std::string name = filled(entry.name.text, name_parts("part.stl.gz", "near"));
  require(name.find_first_of("{}") == std::string::npos, "no placeholder is left", name);
}

void require_shown(const std::vector<Mistake>& mistakes, std::string_view text) {
  const auto lines = static_cast<int>(std::count(text.begin(), text.end(), '\n')) + 3;
  for (const Mistake& mistake : mistakes) {
    require(mistake.line >= 0 && mistake.line <= lines && mistake.column >= 0, "a mistake has a place in the file");
    require((mistake.line == 0) == (mistake.column == 0), "a place is whole", mistake.message);
    require(!mistake.message.empty() && mistake.message.size() < 1000, "a mistake is said shortly", mistake.message);
    require(find_control(mistake.message) == std::string::npos, "a mistake is on one line", mistake.message);
  }
  require(mistakes.size() <= Mistakes::kMost + 1, "mistakes have an end");
}

void check_manifest(std::string_view text) {
  Mistakes found;
  const auto entries = read_manifest(text, found);
  const auto mistakes = std::move(found).sorted();
  if (!mistakes.empty()) return require_shown(mistakes, text);
  require(!entries.empty(), "an accepted manifest has gates");
  Json again{{"version", 1}, {"gates", Json::array()}};
  for (const Entry& entry : entries) {
    require_sound(entry);
    again["gates"].push_back(as_manifest(entry));
  }
  Mistakes none;
  const auto reread = read_manifest(again.dump(), none);
  require(none.empty() && std::equal(entries.begin(), entries.end(), reread.begin(), reread.end(), same_entry),
          "a manifest written anew is read as the same", again.dump());
}

// What stands alone as a flag.
void check_quantities(std::string_view text) {
  if (const auto limit = parse_limit(text)) require_sound(*limit);
  if (const auto duration = parse_duration(text)) {
    require(duration->count() >= 1 && duration->count() <= 180'000, "a duration is in range");
  }
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(manifest) {
  const auto text = meshgauge::fuzz::text_of(data, size);
  meshgauge::fuzz::check_manifest(text);
  meshgauge::fuzz::check_quantities(text);
  return 0;
}
