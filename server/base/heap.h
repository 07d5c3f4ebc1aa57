// Limits how much freed memory the allocator keeps. By default glibc has up to eight arenas per processor and takes
// ever larger blocks from them; memory freed between blocks in use is not given back, and the process grows for hours.
#pragma once

#include <chrono>

namespace meshgauge::server {

// Sets up few arenas, and maps large blocks outside of them. Call once, before any thread starts. Does nothing without
// glibc.
void keep_heap_small(unsigned threads_that_compute);

// Returns whole free pages of all arenas to the kernel. Takes milliseconds per some hundred megabytes; call it rarely.
void release_free_memory();

// From now on operator new waits up to `most` for memory that is used up, before it throws std::bad_alloc.
void wait_for_memory(std::chrono::milliseconds most = std::chrono::seconds(10));

// For the start of a process, while it has promised nothing: operator new that has waited for `most` calls `end`, on
// every thread but those of MayFail, also beside NeverFails. `end` must not return. Null: the start is over.
void end_start_without_memory(void (*end)());

// While it lives, operator new waits on this thread as long as it takes, and never throws: for threads that keep
// promises, where no caller would catch what is thrown.
class NeverFails {
 public:
  NeverFails();
  ~NeverFails();
  NeverFails(const NeverFails&) = delete;
  NeverFails& operator=(const NeverFails&) = delete;
};

// While it lives, operator new throws at once on this thread, also beside NeverFails: for work that is given up without
// memory, and whose memory the others wait for.
class MayFail {
 public:
  MayFail();
  ~MayFail();
  MayFail(const MayFail&) = delete;
  MayFail& operator=(const MayFail&) = delete;
};

}  // namespace meshgauge::server
