// What the allocator keeps of what was freed. By itself glibc gives each thread one of eight arenas a processor, and
// takes ever larger blocks from them: what was freed between blocks in use is not given back, and memory grows for
// hours.
#pragma once

namespace meshgauge::server {

// Once, before any thread begins: few arenas, and large blocks outside of them.
void keep_heap_small(unsigned threads_that_compute);

// Whole free pages, of all arenas. Takes milliseconds for some hundred megabytes: from time to time.
void give_back_free_memory();

}  // namespace meshgauge::server
