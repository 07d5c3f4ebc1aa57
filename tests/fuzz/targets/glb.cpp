// GLB: the input is a file, or the JSON and, behind a NUL, the data of one that is put together here, since hardly any
// mutation leaves the lengths in a file right.
#include <algorithm>
#include <cstring>
#include <string>

#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

namespace {

std::string word(std::size_t value) {
  const auto narrow = static_cast<std::uint32_t>(value);
  std::string out(sizeof narrow, '\0');
  std::memcpy(out.data(), &narrow, sizeof narrow);
  return out;
}

std::string chunk(std::string_view type, std::string_view content, char padding) {
  std::string padded(content);
  padded.append((4 - padded.size() % 4) % 4, padding);
  return word(padded.size()) + std::string(type) + padded;
}

std::string container(std::string_view parts) {
  const std::size_t nul = std::min(parts.find('\0'), parts.size());
  std::string chunks = chunk("JSON", parts.substr(0, nul), ' ');
  if (nul < parts.size()) chunks += chunk(std::string_view("BIN\0", 4), parts.substr(nul + 1), '\0');
  return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

}  // namespace

FUZZ_TARGET(glb) {
  const auto input = meshgauge::fuzz::text_of(data, size);
  meshgauge::fuzz::check_file_of("glb", input.starts_with("glTF") ? std::string(input) : container(input));
  return 0;
}
