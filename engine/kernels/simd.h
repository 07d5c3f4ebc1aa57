// The kernels for the instruction sets of this processor; see kernels.h.
#pragma once

#include <vector>

#include "engine/kernels/kernels.h"

namespace meshgauge {

// Returns the kernels, the fastest first. Empty: Highway does not support this processor.
std::vector<Kernels> simd_kernels();

}  // namespace meshgauge
