#include "tests/api/formats/files.h"

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include "api/formats/gltf/gltf_bundle.h"

namespace meshgauge::api::test {

std::string base64(std::string_view data) {
  const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < data.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8U | (i + k < data.size() ? static_cast<unsigned char>(data[i + k]) : 0U);
    }
    for (unsigned k = 0; k < 4; ++k) out += i + k > data.size() ? '=' : letters[bits >> (18 - 6 * k) & 63U];
  }
  return out;
}

std::optional<std::filesystem::path> corpus() {
  const char* set = std::getenv("MESHGAUGE_CORPUS");
  const std::filesystem::path path = set != nullptr ? set : MESHGAUGE_SOURCE_DIR "/../shared/corpus";
  if (!std::filesystem::is_directory(path)) return std::nullopt;
  return path;
}

std::string file_content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return std::move(content).str();
}

std::string bundled_content(const std::filesystem::path& path) {
  const std::string content = file_content(path);
  if (path.extension() != ".gltf") return content;
  std::map<std::string, std::string> files;
  for (const std::string& name : files_named_by(bytes_of(content)))
    files[name] = file_content(path.parent_path() / name);
  if (files.empty()) return content;
  files[std::string(kBundleScene)] = content;
  std::string archive;
  BundleWriter writer([&](std::string_view piece) { return archive += piece, true; });
  for (const auto& [name, bytes] : files) writer.add(name, bytes_of(bytes));
  writer.finish();
  return archive;
}

std::vector<std::vector<std::string>> table(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '\t');) cells.push_back(cell);
    rows.push_back(std::move(cells));
  }
  return rows;
}

}  // namespace meshgauge::api::test
