// Limits how much freed memory the allocator keeps. By default glibc has up to eight arenas per processor and takes
// ever larger blocks from them; memory freed between blocks in use is not given back, and the process grows for hours.
#pragma once

namespace meshgauge::server {

// Sets up few arenas, and maps large blocks outside of them. Call once, before any thread starts. Does nothing without
// glibc.
void keep_heap_small(unsigned threads_that_compute);

// Returns whole free pages of all arenas to the kernel. Takes milliseconds per some hundred megabytes; call it rarely.
void release_free_memory();

// From now on operator new waits for memory that is used up, up to some seconds, before it throws std::bad_alloc: what
// others free soon is no reason to end a thread that keeps promises. Call once.
void wait_for_memory();

// While it lives, operator new throws at once on this thread: for work that is given up without memory, and whose
// memory the others wait for.
class MayFail {
 public:
  MayFail();
  ~MayFail();
  MayFail(const MayFail&) = delete;
  MayFail& operator=(const MayFail&) = delete;
};

}  // namespace meshgauge::server
