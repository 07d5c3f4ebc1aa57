// Numbers and places as people read them.
#pragma once

#include <string>
#include <string_view>

#include "engine/mesh.h"

namespace meshgauge::check {

std::string shortest(double x);  // the shortest digits that read back as x

// Rounded to `digits` significant ones: for tables, where every digit would be too many.
std::string rounded(double x, int digits = 6);

std::string_view trimmed(std::string_view text);  // without the blanks and line ends around it

std::string text(const Vec3& p);  // "(1, 2.5, 3)", each number by shortest()

}  // namespace meshgauge::check
