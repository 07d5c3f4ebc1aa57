// replay TARGET FILE...: runs a target on files, and on those of folders, without libFuzzer: for CTest, and to look at
// a finding with any compiler and any debugger. Each name is printed before its file is run.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/targets/target.h"

namespace {

namespace fs = std::filesystem;

bool replay(meshgauge::fuzz::Target target, const fs::path& path) {
  std::printf("%s\n", path.c_str());
  std::fflush(stdout);
  std::ifstream file(path, std::ios::binary);
  const std::string read{std::istreambuf_iterator<char>(file), {}};
  if (!file) return std::fprintf(stderr, "%s cannot be read\n", path.c_str()), false;
  const std::vector<std::uint8_t> exact(read.begin(), read.end());
  target(exact.data(), exact.size());
  return true;
}

std::vector<fs::path> files_of(const fs::path& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  const auto& targets = meshgauge::fuzz::targets();
  const auto target = targets.find(argc > 1 ? argv[1] : "");
  if (target == targets.end()) return std::fprintf(stderr, "usage: replay TARGET FILE...\n"), 2;
  std::size_t count = 0;
  for (int i = 2; i < argc; ++i) {
    for (const fs::path& path : files_of(argv[i])) {
      if (!replay(target->second, path)) return 1;
      ++count;
    }
  }
  std::printf("%zu files\n", count);
  return count > 0 ? 0 : 1;
}
