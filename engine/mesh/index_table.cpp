#include "engine/mesh/index_table.h"

#include <random>

namespace meshgauge {

HashSeed::HashSeed() {
  std::random_device device;
  const auto draw = [&] { return std::uint64_t{device()} << 32 | device(); };
  value = draw();
  for (std::uint64_t& factor : factors) factor = draw() | 1;
}

}  // namespace meshgauge
