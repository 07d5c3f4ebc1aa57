// Room for large arrays.
#pragma once

#include <cstddef>
#include <vector>

namespace meshgauge::api {

// Asks the system for huge pages under a block just allocated and not yet written. Only a hint, without effect
// where the system has none. Half of the time of reading a large binary STL would else go to page faults.
void advise_huge_pages(void* block, std::size_t bytes);

template <class T>
void reserve_room(std::vector<T>& array, std::size_t count) {
  array.reserve(count);
  advise_huge_pages(array.data(), array.capacity() * sizeof(T));
}

}  // namespace meshgauge::api
