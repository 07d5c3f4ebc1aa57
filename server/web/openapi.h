// openapi.yaml, as it was when the binary was built.
#pragma once

#include <string_view>

namespace meshgauge::server {

std::string_view openapi_yaml();

}  // namespace meshgauge::server
