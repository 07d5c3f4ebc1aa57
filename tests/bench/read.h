// Reads the mesh files of a benchmark.
#pragma once

#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "api/formats/format.h"

namespace meshgauge::bench {

// Throws std::runtime_error, with the path, if the file is no mesh.
inline Mesh read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw std::runtime_error(path + ": cannot be read");
  auto result = api::read_mesh(std::as_bytes(std::span(bytes)), {"", path, ""}, {});
  if (!result) throw std::runtime_error(path + ": " + result.error().message);
  return std::move(result->mesh);
}

}  // namespace meshgauge::bench
