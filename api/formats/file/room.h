// Allocates large arrays.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace meshgauge::api {

// Asks the system for huge pages for a block just allocated and not yet written. A hint, without effect where there are
// none. Page faults would otherwise take half of the time of reading a large binary STL.
void advise_huge_pages(void* block, std::size_t bytes);

template <class T>
void reserve_room(std::vector<T>& array, std::size_t count) {
  array.reserve(count);
  advise_huge_pages(array.data(), array.capacity() * sizeof(T));
}

// Reserves room for `more` elements at the end. Growing at least doubles the capacity, so that many small additions
// take linear time in total.
template <class T>
void reserve_more(std::vector<T>& array, std::size_t more) {
  if (more > array.capacity() - array.size()) reserve_room(array, std::max(array.size() + more, 2 * array.capacity()));
}

}  // namespace meshgauge::api
