#include "server/heap.h"

#include <cstdlib>  // says whether it is glibc

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace meshgauge::server {

void keep_heap_small([[maybe_unused]] unsigned threads_that_compute) {
#ifdef __GLIBC__
  constexpr int kForAllOthers = 2;  // they wait for clients and disks, and allocate little
  mallopt(M_ARENA_MAX, static_cast<int>(threads_that_compute) + kForAllOthers);
  // Blocks from here on are mapped, each by itself, and gone when they are freed. This is where glibc begins; left
  // alone, it raises the limit to the largest block that was ever freed, up to 32 MiB.
  mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  mallopt(M_TRIM_THRESHOLD, 1024 * 1024);  // of an arena's free end; setting the one above leaves it at 128 KiB
#endif
}

void give_back_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace meshgauge::server
