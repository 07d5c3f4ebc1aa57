// Limits how much freed memory the allocator keeps. By default glibc has up to eight arenas per processor and takes
// ever larger blocks from them; memory freed between blocks in use is not given back, and the process grows for hours.
#pragma once

namespace meshgauge::server {

// Sets up few arenas, and maps large blocks outside of them. Call once, before any thread starts. Does nothing without
// glibc.
void keep_heap_small(unsigned threads_that_compute);

// Returns whole free pages of all arenas to the kernel. Takes milliseconds per some hundred megabytes; call it rarely.
void release_free_memory();

}  // namespace meshgauge::server
