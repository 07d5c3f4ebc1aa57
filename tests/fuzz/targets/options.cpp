// The options of a request. Asserted of those that are accepted: every number is within its range; written as JSON they
// are read as the same again. A refusal is about the options, and can be sent.
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "api/options/gate.h"
#include "api/options/quantity.h"
#include "api/options/request.h"
#include "api/options/table.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using api::Request;

void require_within(double value, const api::Range& range, std::string_view option) {
  require(api::in_range(value, range, option).ok(), "a number is in the range of its option", option);
}

void require_in_range(const Request& request, const api::RequestLimits& limits) {
  api::ComparisonOptions options = request.options;
  const api::Json document = json_of(request);
  for (const api::Option* option : api::all_options()) {
    const auto written = document.find(std::string(option->key));
    if (option->kind == api::OptionKind::count && written != document.end())
      require_within(written->get<double>(), option->range, option->key);
    if (!option->lengths) continue;
    for (const double* length : option->lengths(options)) require_within(*length, api::kMaxDistanceRange, option->key);
  }
  const Tolerance& rules = options.tolerance;
  for (const auto& rule : {rules.absolute, rules.diagonal, rules.relative})
    require_within(rule.value_or(0), api::kToleranceRange, "tolerance");
  require(rules.absolute || rules.diagonal || rules.relative, "there is a rule to stop by");
  require(is_stencil(options.points), "the number of points is a stencil");
  require(!options.units.limit || !first_length(options).empty(), "a unit of the limits goes with a length in it");
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
