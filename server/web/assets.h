// What build.mjs made of the pages / and /docs, as it was when the binary was built.
#pragma once

#include <string_view>
#include <vector>

namespace meshgauge::server {

struct Asset {
  std::string_view name;  // with its folder: "page/index.html"
  std::string_view gzip;  // the file, compressed
};

const std::vector<Asset>& assets();  // none: built without them

}  // namespace meshgauge::server
