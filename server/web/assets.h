// The files of the page /docs, as they were when the binary was built.
#pragma once

#include <string_view>
#include <vector>

namespace meshgauge::server {

struct Asset {
  std::string_view name;
  std::string_view bytes;
};

const std::vector<Asset>& assets();  // none: built without them

}  // namespace meshgauge::server
