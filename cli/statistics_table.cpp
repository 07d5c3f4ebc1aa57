#include "cli/statistics_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <optional>

#include "api/names.h"
#include "api/with_unit.h"

namespace meshgauge::cli {
namespace {

constexpr double kBarWidth = 50;  // in characters
constexpr std::size_t kBinsALine = 2;

__attribute__((format(printf, 1, 2))) std::string formatted(const char* format, ...) {
  char line[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return line;
}

std::string number_line(const char* name, const Estimate& estimate) {
  return formatted("  %-9s %-12.6g +- %.2g\n", name, estimate.value, estimate.standard_error);
}

// Returns bars in proportion to the longest one.
std::string bars(const Distribution& found) {
  std::array<double, Distribution::kBins / kBinsALine> shares{};
  for (std::size_t b = 0; b < found.histogram.size(); ++b) shares[b / kBinsALine] += found.histogram[b].value;
  const double longest = *std::max_element(shares.begin(), shares.end());
  const double step = found.max_seen / static_cast<double>(shares.size());
  std::string out;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto length = static_cast<std::size_t>(std::lround(shares[i] / longest * kBarWidth));
    out += formatted("  up to %-12.6g %6.2f %%%s\n", step * static_cast<double>(i + 1), 100 * shares[i],
                     (length > 0 ? " " + std::string(length, '#') : "").c_str());
  }
  return out;
}

using Unit = std::optional<api::LengthUnit>;

std::string direction(const char* name, const std::optional<Distribution>& found, const Unit& unit) {
  if (!found) return "";
  std::string out = formatted("sampled   %s: %zu points by %s, value +- standard error%s\n", name, found->samples,
                              std::string(api::name_of(api::kWeights, found->weight)).c_str(),
                              unit ? api::with_unit(", in", unit).c_str() : "");
  out += number_line("mean", found->mean) + number_line("rms", found->rms) + number_line("p50", found->p50) +
         number_line("p95", found->p95) + number_line("p99", found->p99);
  return out + formatted("  %-9s %.6g\n", "max seen", found->max_seen) + bars(*found);
}

}  // namespace

std::string to_table(const Statistics& statistics, const Unit& unit) {
  std::string out = direction("a to b", statistics.a_to_b, unit) + direction("b to a", statistics.b_to_a, unit);
  if (statistics.status != StatisticsStatus::complete) {
    out += "sampled   not everything that was asked for: " +
           std::string(api::name_of(api::kStatisticsStatuses, statistics.status)) + "\n";
  }
  return out;
}

}  // namespace meshgauge::cli
