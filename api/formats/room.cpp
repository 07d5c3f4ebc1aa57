#include "api/formats/room.h"

#include <sys/mman.h>

#include <cstdint>

namespace meshgauge::api {

void advise_huge_pages(void* block, std::size_t bytes) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20U;
  constexpr std::uintptr_t kPage = 4096;
  if (bytes < 2 * kHugePage) return;
  const std::uintptr_t first = (reinterpret_cast<std::uintptr_t>(block) + kPage - 1) & ~(kPage - 1);
  const std::uintptr_t last = (reinterpret_cast<std::uintptr_t>(block) + bytes) & ~(kPage - 1);
  static_cast<void>(madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE));
}

}  // namespace meshgauge::api
