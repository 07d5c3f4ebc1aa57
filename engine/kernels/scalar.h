// The reference for the kernels, in plain C++; see kernels.h.
#pragma once

#include "engine/kernels/kernels.h"

namespace meshgauge {

Kernels scalar_kernels();

}  // namespace meshgauge
