#include "api/request.h"

#include "api/json_filter.h"
#include "api/refused.h"

namespace meshgauge::api {

Result<std::string_view> as_simd(std::string_view value, std::string_view name) {
  const auto all = supported_simd();
  if (value == "auto") return all.front();
  for (const std::string_view supported : all) {
    if (value == supported) return supported;
  }
  return refused(std::string(name) + " must be one of " + simd_names() + " on this processor, not " + shown_text(value),
                 "options", std::string(name));
}

std::string simd_names() {
  std::string list = "auto";
  for (const std::string_view name : supported_simd()) list.append(", ").append(name);
  return list;
}

}  // namespace meshgauge::api
