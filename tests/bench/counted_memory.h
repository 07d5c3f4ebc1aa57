// Counts what the program holds: its own operator new and delete, so every container is seen. Thread safe.
#pragma once

#include <cstddef>

namespace meshgauge::bench {

// Bytes held now, as the allocator rounds them.
std::size_t held_bytes();

// The most that was held at once since the last reset_peak().
std::size_t peak_bytes();
void reset_peak();

}  // namespace meshgauge::bench
