// Makes a failing pair small: fewer triangles, fewer digits.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "fuzz/generate.h"

namespace meshgauge::fuzz {

// The smallest pair found within `patience` for which `fails` holds. Precondition: it holds for `pair`.
Pair shrink(Pair pair, const std::function<bool(const Pair&)>& fails, std::chrono::milliseconds patience);

// As OBJ, coordinates with 17 digits: reads back as the same doubles.
std::string to_obj(const Mesh& mesh);

}  // namespace meshgauge::fuzz
