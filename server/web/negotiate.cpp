#include "server/web/negotiate.h"

#include <charconv>
#include <string>

#include "server/http/text.h"

namespace meshgauge::server {
namespace {

// How specifically the range matches; 0: not at all.
int fit(const std::string& range, std::string_view value) {
  if (range == value) return 3;
  if (range == "*/*" || range == "*") return 1;
  const bool any_of_type = range.size() > 2 && range.ends_with("/*");
  return any_of_type && value.starts_with(std::string_view(range).substr(0, range.size() - 1)) ? 2 : 0;
}

double weight(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string parameter = lower(trimmed(next(parameters, ";")));
    if (!parameter.starts_with("q=")) continue;
    double q = 0;
    const char* const end = parameter.data() + parameter.size();
    const auto read = std::from_chars(parameter.data() + 2, end, q, std::chars_format::fixed);
    return read.ec == std::errc() && read.ptr == end && q >= 0 && q <= 1 ? q : 0;
  }
  return 1;
}

}  // namespace

double weight_of(std::string_view field, std::string_view value) {
  int best = 0;
  double found = 0;
  while (!field.empty()) {
    std::string_view element = next(field, ",");
    const int fits = fit(lower(trimmed(next(element, ";"))), value);
    if (fits <= best) continue;
    best = fits;
    found = weight(element);
  }
  return found;
}

}  // namespace meshgauge::server
