// What the build embeds into the binary: openapi.yaml, the schema of manifests (check/gates.schema.json), and the files
// of the pages / and /docs, which build.mjs makes.
#pragma once

#include <string_view>
#include <vector>

namespace meshgauge::server {

std::string_view openapi_yaml();
std::string_view gates_schema();

struct Asset {
  std::string_view name;  // with its folder: "page/index.html"
  std::string_view gzip;  // the file's bytes, compressed by gzip
};

const std::vector<Asset>& assets();  // empty: the binary was built without pages

}  // namespace meshgauge::server
