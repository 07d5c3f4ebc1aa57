#include "engine/index_table.h"

#include <random>

namespace meshgauge {

std::uint64_t hash_seed() {
  static const std::uint64_t value = (std::uint64_t{std::random_device{}()} << 32) | std::random_device{}();
  return value;
}

}  // namespace meshgauge
