#include "server/heap.h"

#include <cstdlib>  // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace meshgauge::server {

void keep_heap_small([[maybe_unused]] unsigned threads_that_compute) {
#ifdef __GLIBC__
  constexpr int kForAllOthers = 2;  // threads that wait for clients and disks allocate little
  mallopt(M_ARENA_MAX, static_cast<int>(threads_that_compute) + kForAllOthers);
  // Larger blocks get a mapping each, which ends when they are freed. 128 KiB is glibc's initial value; without this
  // call it rises to the largest block that was ever freed, up to 32 MiB.
  mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  mallopt(M_TRIM_THRESHOLD, 1024 * 1024);  // free bytes at an arena's end; the call above fixes it at 128 KiB
#endif
}

void release_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace meshgauge::server
