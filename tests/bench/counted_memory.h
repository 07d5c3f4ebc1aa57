// Counts the memory of the program with its own operator new and delete, which every container uses. Thread safe.
#pragma once

#include <cstddef>

namespace meshgauge::bench {

// Bytes held now, as the allocator rounds them.
std::size_t held_bytes();

// The largest number of bytes held at once since the last reset_peak().
std::size_t peak_bytes();
void reset_peak();

}  // namespace meshgauge::bench
