// A binary heap in an array, the largest element first. As the functions of the standard library of the same names,
// which leave open which of several equal elements comes first: here that follows from the elements' order in the array
// alone, so that a search splits its pieces in the same order everywhere.
#pragma once

#include <cstddef>
#include <span>
#include <utility>

namespace meshgauge {

// Puts `value` into the place `hole` or above, up to `top`: behind its equals.
template <class T, class Less>
void sift_up(std::span<T> heap, std::size_t hole, std::size_t top, T value, Less less) {
  while (hole > top && less(heap[(hole - 1) / 2], value)) {
    heap[hole] = std::move(heap[(hole - 1) / 2]);
    hole = (hole - 1) / 2;
  }
  heap[hole] = std::move(value);
}

// Moves the larger child up into the hole, of equals the second, down to a leaf; then `value` up from there. Mostly it
// comes from a leaf and is small, so that this takes half of the comparisons of stopping where it belongs.
template <class T, class Less>
void sift_down(std::span<T> heap, std::size_t hole, T value, Less less) {
  const std::size_t top = hole;
  for (std::size_t child; (child = 2 * hole + 1) < heap.size(); hole = child) {
    if (child + 1 < heap.size() && !less(heap[child + 1], heap[child])) ++child;
    heap[hole] = std::move(heap[child]);
  }
  sift_up(heap, hole, top, std::move(value), less);
}

// Precondition: all but the last element are a heap.
template <class T, class Less>
void push_heap(std::span<T> heap, Less less) {
  sift_up(heap, heap.size() - 1, 0, T(std::move(heap.back())), less);
}

// Moves the largest element to the end. Precondition: a heap that is not empty.
template <class T, class Less>
void pop_heap(std::span<T> heap, Less less) {
  if (heap.size() < 2) return;
  T value = std::exchange(heap.back(), std::move(heap.front()));
  sift_down(heap.first(heap.size() - 1), 0, std::move(value), less);
}

template <class T, class Less>
void make_heap(std::span<T> heap, Less less) {
  for (std::size_t i = heap.size() / 2; i-- > 0;) sift_down(heap, i, T(std::move(heap[i])), less);
}

}  // namespace meshgauge
