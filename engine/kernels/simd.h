// The kernels for the instruction sets of this processor; see kernels.h.
#pragma once

#include <vector>

#include "engine/kernels/kernels.h"

namespace meshgauge {

// The fastest first. None on a processor that Highway knows nothing about.
std::vector<Kernels> simd_kernels();

}  // namespace meshgauge
