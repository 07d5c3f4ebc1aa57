// The options of a request. Asserted of those that are accepted: every number is within its range; written as JSON they
// are read as the same again. A refusal is about the options, and can be sent.
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "api/names.h"
#include "api/request.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using Json = nlohmann::ordered_json;
using api::Request;

Json json_of(const Tolerance& tolerance) {
  Json json = Json::object();
  if (tolerance.absolute) json["absolute"] = *tolerance.absolute;
  if (tolerance.diagonal) json["diagonal"] = *tolerance.diagonal;
  if (tolerance.relative) json["relative"] = *tolerance.relative;
  return json;
}

// Every member that a request can have; the number of work items has a default that cannot be written.
std::string written(const Request& request) {
  const api::ComparisonOptions& options = request.options;
  Json json{{"direction", name_of(api::kDirections, options.direction)},
            {"strategy", name_of(api::kStrategies, options.strategy)},
            {"tolerance", json_of(options.tolerance)},
            {"timeout_ms", request.timeout.count()},
            {"threads", options.threads},
            {"budget", {{"memory_bytes", options.max_memory_bytes}}}};
  if (options.max_distance) json["gate"]["max_distance"] = *options.max_distance;
  const std::string_view limit_unit = api::limit_unit_name(options.units);
  if (options.max_distance && !limit_unit.empty()) json["gate"]["units"] = limit_unit;
  if (options.units.a) json["units"]["a"] = to_string(*options.units.a);
  if (options.units.b) json["units"]["b"] = to_string(*options.units.b);
  if (options.strategy == Strategy::n_point) json["points"] = options.points;
  if (options.max_work_items != std::numeric_limits<std::uint64_t>::max()) {
    json["budget"]["work_items"] = options.max_work_items;
  }
  return json.dump();
}

bool same(const Request& a, const Request& b) {
  const Options &x = a.options, &y = b.options;
  return a.timeout == b.timeout && a.options.units == b.options.units && x.direction == y.direction &&
         x.tolerance.absolute == y.tolerance.absolute && x.tolerance.diagonal == y.tolerance.diagonal &&
         x.tolerance.relative == y.tolerance.relative && x.max_distance == y.max_distance && x.strategy == y.strategy &&
         x.points == y.points && x.max_memory_bytes == y.max_memory_bytes && x.max_work_items == y.max_work_items &&
         x.threads == y.threads && x.simd == y.simd;
}

void require_within(std::optional<double> value, const api::Range& range, const char* what) {
  require(!value || api::in_range(*value, range, what).ok(), what);
}

void require_in_range(const Request& request, const api::RequestLimits& limits) {
  const api::ComparisonOptions& options = request.options;
  require_within(options.tolerance.absolute, api::kToleranceRange, "the absolute tolerance is in range");
  require_within(options.tolerance.diagonal, api::kToleranceRange, "the tolerance by the diagonal is in range");
  require_within(options.tolerance.relative, api::kToleranceRange, "the relative tolerance is in range");
  require_within(options.max_distance, api::kMaxDistanceRange, "the gate's distance is in range");
  require_within(options.threads, api::kThreadsRange, "the number of threads is in range");
  require(options.tolerance.absolute || options.tolerance.diagonal || options.tolerance.relative,
          "there is a rule to stop by");
  require(is_stencil(options.points), "the number of points is a stencil");
  require(!options.units.limit || options.max_distance, "a unit of the limit goes with a limit");
  require(request.timeout.count() >= 1 && request.timeout <= limits.max_timeout, "the time is within the limit");
}

void check(std::string_view text, const api::RequestLimits& limits) {
  const auto request = parse_options(text, limits);
  if (!request) {
    require(request.error().part == "options", "a refusal is about the options", request.error().message);
    return require_answer(request.error());
  }
  require_in_range(*request, limits);
  const std::string json = written(*request);
  const auto again = parse_options(json, limits);
  require(again.ok() && same(*request, *again), "options written anew are read as the same", json);
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(options) {
  using std::chrono::milliseconds;
  const auto text = meshgauge::fuzz::text_of(data, size);
  meshgauge::fuzz::check(text, {});
  meshgauge::fuzz::check(text, {milliseconds(50), milliseconds(100)});
  return 0;
}
