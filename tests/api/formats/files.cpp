#include "tests/api/formats/files.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <utility>

namespace meshgauge::api::test {

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
