#include "cli/heap.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>  // defines __GLIBC__
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {

// What the kernel was told of the mapping in which `address` lies.
std::string flags_of(const void* address) {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/smaps");
  bool inside = false;
  for (std::string line; std::getline(maps, line);) {
    std::istringstream words(line);
    std::uintptr_t low = 0, high = 0;
    if (char dash = 0; words >> std::hex >> low >> dash >> high && dash == '-') inside = low <= at && at < high;
    if (inside && line.starts_with("VmFlags:")) return line;
  }
  return "";
}

}  // namespace

TEST_CASE("heap: what a command allocates lies in huge pages" *
          doctest::skip(!std::filesystem::exists("/sys/kernel/mm/transparent_hugepage/enabled"))) {
  const auto before = std::make_unique<std::byte[]>(std::size_t{1} << 20);
  CHECK(flags_of(before.get()).find(" hg") == std::string::npos);
  meshgauge::cli::use_huge_pages();
  for (const std::size_t bytes : {std::size_t{1} << 20, std::size_t{3} << 20}) {
    const auto block = std::make_unique<std::byte[]>(bytes);
    CHECK(flags_of(block.get()).find(" hg") != std::string::npos);
  }
}
#endif
