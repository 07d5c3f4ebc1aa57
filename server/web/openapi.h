// openapi.yaml, embedded by the build.
#pragma once

#include <string_view>

namespace meshgauge::server {

std::string_view openapi_yaml();

}  // namespace meshgauge::server
