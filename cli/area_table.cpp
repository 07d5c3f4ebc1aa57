#include "cli/area_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "api/area_json.h"
#include "api/decimal.h"
#include "api/figures.h"
#include "api/names.h"
#include "api/with_unit.h"

namespace meshgauge::cli {
namespace {

// Rounds the ends outwards to four decimals, so that what is printed holds.
std::string percent_range(const AreaInterval& share) {
  const double lower = std::max(0.0, std::floor(share.lower * 1e6 - 1e-6) / 1e4);
  const double upper = std::min(100.0, std::ceil(share.upper * 1e6 + (share.upper > 0 ? 1e-6 : 0)) / 1e4);
  char text[64];
  std::snprintf(text, sizeof text, "%.4f .. %.4f %%", lower, upper);
  return text;
}

std::string length_range(const AreaInterval& length) {
  const api::IntervalText text = api::to_text(length.lower, length.upper, std::numeric_limits<double>::infinity());
  return text.lower + " .. " + text.upper;
}

std::string percentile(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "p%.15g", 100 * share);  // 7, where 100 * 0.07 is a little more
  return text;
}

std::string area_line(const std::string& what, const std::string& value) {
  return "  " + what + std::string(what.size() < 24 ? 24 - what.size() : 1, ' ') + value + "\n";
}

std::string area_lines(const char* name, const std::optional<AreaBounds>& found, const AreaOptions& asked,
                       const std::optional<api::LengthUnit>& unit) {
  if (!found) return "";
  std::string out = std::string("certified ") + name + ": by area, lower .. upper" +
                    (unit ? api::with_unit(", in", unit) : "") + "\n";
  for (std::size_t k = 0; k < found->beyond.size(); ++k) {
    out += area_line("share beyond " + api::shortest(asked.beyond[k].distance), percent_range(found->beyond[k]));
  }
  for (std::size_t q = 0; q < found->quantiles.size(); ++q) {
    out += area_line(percentile(asked.quantiles[q]), length_range(found->quantiles[q]));
  }
  if (found->mean) out += area_line("mean", length_range(*found->mean));
  if (found->rms) out += area_line("rms", length_range(*found->rms));
  if (found->stop != AreaStop::complete) {
    out += area_line("ended by", std::string(api::name_of(api::kAreaStops, found->stop)));
  }
  return out;
}

}  // namespace

std::string to_table(const AreaOutcome& areas, const std::optional<api::LengthUnit>& unit) {
  return area_lines("a to b", areas.a_to_b, areas.options, unit) +
         area_lines("b to a", areas.b_to_a, areas.options, unit);
}

std::string to_table(const SideOutcome& sides, const std::optional<api::LengthUnit>& unit) {
  std::string out =
      "certified a to b: by side of b, lower .. upper" + (unit ? api::with_unit(", in", unit) : std::string()) + "\n";
  if (sides.refused) return out + area_line("none", api::in_words(*sides.refused, unit));
  out += area_line("outside", length_range({sides.outside.lower, sides.outside.upper}));
  out += area_line("inside", length_range({sides.inside.lower, sides.inside.upper}));
  if (sides.stop != AreaStop::complete)
    out += area_line("ended by", std::string(api::name_of(api::kAreaStops, sides.stop)));
  return out;
}

}  // namespace meshgauge::cli
