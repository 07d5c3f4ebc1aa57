#include "server/heap.h"

#include <array>
#include <cstddef>
#include <memory>

#include <doctest/doctest.h>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#include <malloc.h>

using namespace meshgauge;

// By default glibc takes blocks of a size from its arenas once one of that size was freed.
TEST_CASE("heap: large blocks stay mapped, also after some were freed") {
  server::keep_heap_small(2);
  constexpr std::size_t kSize = std::size_t{1} << 20;
  const std::size_t before = mallinfo2().hblks;
  for (int round = 0; round < 3; ++round) {
    std::array<std::unique_ptr<std::byte[]>, 4> blocks;
    for (auto& block : blocks) block = std::make_unique_for_overwrite<std::byte[]>(kSize);
    CHECK(mallinfo2().hblks == before + blocks.size());
  }
  CHECK(mallinfo2().hblks == before);
}

#endif
