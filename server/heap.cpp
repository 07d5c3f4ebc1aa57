#include "server/heap.h"

#include <cstdlib>  // says whether it is glibc

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace meshgauge::server {

void limit_arenas([[maybe_unused]] unsigned threads_that_compute) {
#ifdef __GLIBC__
  constexpr int kForAllOthers = 2;  // they wait for clients and disks, and allocate little
  mallopt(M_ARENA_MAX, static_cast<int>(threads_that_compute) + kForAllOthers);
#endif
}

void give_back_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace meshgauge::server
