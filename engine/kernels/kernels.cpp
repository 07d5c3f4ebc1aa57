#include "engine/kernels/kernels.h"

#include <vector>

namespace meshgauge {

std::span<const Kernels> supported_kernels() {
  static const std::vector<Kernels> all = [] {
    std::vector<Kernels> kernels = simd_kernels();
    kernels.push_back(scalar_kernels());
    return kernels;
  }();
  return all;
}

const Kernels* find_kernels(std::string_view name) {
  for (const Kernels& kernels : supported_kernels()) {
    if (name == "auto" || name == kernels.name) return &kernels;
  }
  return nullptr;
}

}  // namespace meshgauge
