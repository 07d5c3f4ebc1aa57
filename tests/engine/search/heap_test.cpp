// The heap of a search: the order of equals follows from the order in which they came, not from the standard library.
#include "engine/search/heap.h"

#include <algorithm>
#include <random>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;

namespace {

struct Item {
  int key;
  int name;
};
constexpr auto kLess = [](const Item& a, const Item& b) { return a.key < b.key; };

void push(std::vector<Item>& heap, const Item& item) {
  heap.push_back(item);
  push_heap(std::span(heap), kLess);
}

Item pop(std::vector<Item>& heap) {
  pop_heap(std::span(heap), kLess);
  const Item item = heap.back();
  heap.pop_back();
  return item;
}

std::vector<int> names_in_order(std::vector<Item> heap) {
  std::vector<int> names;
  while (!heap.empty()) names.push_back(pop(heap).name);
  return names;
}

}  // namespace

TEST_CASE("heap: the largest first, and each once") {
  std::mt19937 bits(3);
  for (int size = 1; size < 100; ++size) {
    std::vector<Item> pushed, made;
    for (int i = 0; i < size; ++i) {
      made.push_back({static_cast<int>(bits() % 10), i});
      push(pushed, made.back());
    }
    make_heap(std::span(made), kLess);
    for (std::vector<Item>* heap : {&pushed, &made}) {
      std::vector<bool> seen(static_cast<std::size_t>(size), false);
      for (int last = 10; !heap->empty();) {
        const Item item = pop(*heap);
        CHECK(item.key <= last);
        CHECK_FALSE(seen[static_cast<std::size_t>(item.name)]);
        seen[static_cast<std::size_t>(item.name)] = true;
        last = item.key;
      }
      CHECK(std::ranges::count(seen, false) == 0);
    }
  }
}

TEST_CASE("heap: equals come in the order that libstdc++ gives them") {
  std::vector<Item> equal, made, mixed;
  for (int i = 0; i < 9; ++i) {
    push(equal, {1, i});
    made.push_back({1, i});
    push(mixed, {i % 3, i});
  }
  make_heap(std::span(made), kLess);
  CHECK(names_in_order(equal) == std::vector{0, 2, 6, 8, 5, 7, 4, 1, 3});
  CHECK(names_in_order(made) == std::vector{6, 2, 0, 3, 5, 7, 1, 4, 8});
  CHECK(names_in_order(mixed) == std::vector{2, 5, 8, 1, 7, 4, 6, 3, 0});
}
