// The options of a request. Asserted of those that are accepted: every number is within its range; written as JSON they
// are read as the same again. A refusal is about the options, and can be sent.
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "api/options/names.h"
#include "api/options/request.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using api::Request;

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
  require(!options.units.limit || has_limit(options), "a unit of the limit goes with a limit");
  require(request.timeout.count() >= 1 && request.timeout <= limits.max_timeout, "the time is within the limit");
}

void check(std::string_view text, const api::RequestLimits& limits) {
  const auto request = parse_options(text, limits);
  if (!request) {
    require(request.error().part == "options", "a refusal is about the options", request.error().message);
    return require_answer(request.error());
  }
  require_in_range(*request, limits);
  const std::string json = json_of(*request).dump();
  const auto again = parse_options(json, limits);
  require(again.ok() && json_of(*again).dump() == json, "options written anew are read as the same", json);
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
