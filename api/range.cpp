#include "api/range.h"

#include <cmath>
#include <cstdint>

#include <nlohmann/json.hpp>

#include "api/refused.h"

namespace meshgauge::api {
namespace {

std::string text_of(double x) {
  if (!std::isfinite(x)) return std::isnan(x) ? "NaN" : "infinite";
  const bool whole = std::nearbyint(x) == x && std::abs(x) < 1e15;
  return whole ? std::to_string(static_cast<std::int64_t>(x)) : nlohmann::json(x).dump();
}

}  // namespace

std::string described(const Range& range) {
  if (range.integer) return "an integer from " + text_of(range.low) + " to " + text_of(range.high);
  if (range.low == -Range{}.high) return "a finite number of at most " + text_of(range.high);
  if (range.high < Range{}.high) return "a number from " + text_of(range.low) + " to " + text_of(range.high);
  return "a finite number of at least " + text_of(range.low);
}

Result<double> in_range(double value, const Range& range, std::string_view name) {
  const bool whole = !range.integer || std::nearbyint(value) == value;
  if (value >= range.low && value <= range.high && whole) return value;  // false for NaN
  return refused(std::string(name) + " must be " + described(range) + ", not " + text_of(value), "options",
                 std::string(name));
}

}  // namespace meshgauge::api
