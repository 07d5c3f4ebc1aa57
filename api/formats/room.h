// Room for large arrays.
#pragma once

#include <algorithm>
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

// Room for `more` at the end. Where the array has to grow it at least doubles, so that many small additions take
// linear time together.
template <class T>
void reserve_more(std::vector<T>& array, std::size_t more) {
  if (more > array.capacity() - array.size()) reserve_room(array, std::max(array.size() + more, 2 * array.capacity()));
}

}  // namespace meshgauge::api
