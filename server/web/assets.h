// The files of the pages / and /docs, which build.mjs makes and the build embeds.
#pragma once

#include <string_view>
#include <vector>

namespace meshgauge::server {

struct Asset {
  std::string_view name;  // with its folder: "page/index.html"
  std::string_view gzip;  // the file's bytes, compressed by gzip
};

const std::vector<Asset>& assets();  // empty: the binary was built without pages

}  // namespace meshgauge::server
