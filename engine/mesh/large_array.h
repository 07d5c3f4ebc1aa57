// Vectors for large arrays that are read in random order.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace meshgauge {

// Aligns to cache lines; for large arrays to huge pages, which it asks the system for: that halves the misses of
// address translation in a query. resize() leaves elements of trivial types uninitialised.
template <class T>
struct LargeAllocator {
  using value_type = T;
  static constexpr std::size_t kLine = 64;
  static constexpr std::size_t kHugePage = std::size_t{2} << 20;

  LargeAllocator() = default;
  template <class U>
  explicit LargeAllocator(const LargeAllocator<U>&) noexcept {}

  T* allocate(std::size_t count) {
    void* const memory = ::operator new(count * sizeof(T), alignment_of(count));
#ifdef __linux__
    if (alignment_of(count) == std::align_val_t{kHugePage})
      madvise(memory, count * sizeof(T), MADV_HUGEPAGE);  // best effort: a refusal only costs speed
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) noexcept { ::operator delete(memory, alignment_of(count)); }

  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }

  static std::align_val_t alignment_of(std::size_t count) {
    return std::align_val_t{count * sizeof(T) >= 2 * kHugePage ? kHugePage : kLine};
  }

  bool operator==(const LargeAllocator&) const noexcept { return true; }
};

template <class T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

template <class T>
std::size_t bytes_of(const LargeArray<T>& array) {
  return array.capacity() * sizeof(T);
}

}  // namespace meshgauge
