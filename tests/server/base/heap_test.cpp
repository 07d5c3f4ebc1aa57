#include "server/base/heap.h"

#include <array>
#include <cstddef>
#include <memory>
#include <new>

#include <doctest/doctest.h>

using namespace meshgauge;

TEST_CASE("heap: threads that keep promises wait for memory as long as it takes") {
  server::wait_for_memory(std::chrono::milliseconds(0));
  const std::new_handler handler = std::set_new_handler(nullptr);  // what operator new calls where memory is missing
  const auto twice = [&] {
    handler();
    handler();
  };
  CHECK_THROWS_AS(twice(), std::bad_alloc);
  const server::NeverFails never_fails;
  CHECK_NOTHROW(twice());
  const server::MayFail may_fail;
  CHECK_THROWS_AS(handler(), std::bad_alloc);
}

TEST_CASE("heap: a start that waits for memory in vain is ended") {
  struct Ended {};
  server::wait_for_memory(std::chrono::milliseconds(0));
  const std::new_handler handler = std::set_new_handler(nullptr);
  server::end_start_without_memory([] { throw Ended(); });
  const auto thrice = [&] {
    for (int i = 0; i < 3; ++i) handler();
  };
  CHECK_THROWS_AS(thrice(), Ended);
  {
    const server::NeverFails never_fails;
    CHECK_THROWS_AS(thrice(), Ended);
    const server::MayFail may_fail;
    CHECK_THROWS_AS(handler(), std::bad_alloc);
  }
  server::end_start_without_memory(nullptr);
  CHECK_THROWS_AS(thrice(), std::bad_alloc);
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#include <malloc.h>

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
