#include "cli/heap.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>  // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace meshgauge::cli {

void use_huge_pages() {
#ifdef __GLIBC__
  constexpr std::size_t kHugePage = std::size_t{2} << 20U;
  constexpr std::size_t kPage = 4096;
  constexpr int kRoom = 64 << 20;
  mallopt(M_TOP_PAD, kRoom);
  mallopt(M_TRIM_THRESHOLD, 2 * kRoom);
  mallopt(M_MMAP_THRESHOLD, 2 * kHugePage);  // from there on the engine's arrays ask for huge pages (large_array.h)
  // The blocks are kept and never touched. The first moves the heap's end by kRoom. The second reaches to the first
  // huge page, so that what is allocated next lies there. Where a block ends the allocator touches a page: none of
  // those that become huge.
  constexpr std::size_t kEnough = std::size_t{256} << 10U;
  static auto* const block = static_cast<std::byte*>(std::malloc(kEnough));
  auto* const end = static_cast<std::byte*>(sbrk(0));
  if (block == nullptr || end < block + 2 * kEnough) return;  // another allocator
  void* first = block + kEnough + kPage;
  auto room = static_cast<std::size_t>(end - static_cast<std::byte*>(first));
  if (std::align(kHugePage, kHugePage, first, room) == nullptr) return;
  static_cast<void>(madvise(first, room, MADV_HUGEPAGE));  // best effort: a refusal only costs speed
  static void* volatile gap = std::malloc(static_cast<std::size_t>(static_cast<std::byte*>(first) - block) - kEnough);
  static_cast<void>(gap);
#endif
}

}  // namespace meshgauge::cli
