#include "check/gate.h"

#include <cstddef>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/options/gate.h"

namespace meshgauge::check {

api::ComparisonOptions options_in(const Gate& gate, const nlohmann::ordered_json& document) {
  api::ComparisonOptions options = gate.request.options;
  const nlohmann::ordered_json::json_pointer diagonal("/meshes/b/diagonal");
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const bool is_known = document.contains(diagonal) && document[diagonal].is_number();
  api::resolve_shares(options, is_known ? document[diagonal].get<double>() : kUnknown);
  return options;
}

// One pass: 'a' or 'b' inside a file's name is not replaced again.
Error with_files(Error error, const Gate& gate) {
  const std::string& message = error.message;
  std::string text;
  for (std::size_t i = 0; i < message.size();) {
    const bool a = message.compare(i, 3, "'a'") == 0, b = message.compare(i, 3, "'b'") == 0;
    text += a || b ? "'" + (a ? gate.candidate : gate.baseline).string() + "'" : std::string(1, message[i]);
    i += a || b ? 3 : 1;
  }
  error.message = std::move(text);
  return error;
}

}  // namespace meshgauge::check
