// Shrinks a failing pair: fewer triangles, fewer digits.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "fuzz/generate.h"

namespace meshgauge::fuzz {

// Returns the smallest pair found within `patience` for which `fails` holds. Precondition: it holds for `pair`.
Pair shrink(Pair pair, const std::function<bool(const Pair&)>& fails, std::chrono::milliseconds patience);

// Returns the mesh as OBJ. Coordinates have 17 digits and read back as the same doubles.
std::string to_obj(const Mesh& mesh);

}  // namespace meshgauge::fuzz
