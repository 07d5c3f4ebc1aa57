// What the allocator keeps of what was freed. By itself glibc gives each thread one of eight arenas a processor, and an
// arena gives back nothing but its end: so memory would grow for hours, to what each arena's threads needed at most.
#pragma once

namespace meshgauge::server {

// Once, before any thread begins.
void limit_arenas(unsigned threads_that_compute);

// Whole free pages, of all arenas. Takes milliseconds for some hundred megabytes: from time to time.
void give_back_free_memory();

}  // namespace meshgauge::server
