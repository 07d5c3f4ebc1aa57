#include "api/formats/file/room.h"

#include <sys/mman.h>

#include <memory>

namespace meshgauge::api {

void advise_huge_pages(void* block, std::size_t bytes) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20U;
  constexpr std::size_t kPage = 4096;
  if (bytes < 2 * kHugePage || std::align(kPage, kPage, block, bytes) == nullptr) return;
  static_cast<void>(madvise(block, bytes / kPage * kPage, MADV_HUGEPAGE));
}

}  // namespace meshgauge::api
