// Formats a comparison as a table for people.
#pragma once

#include <string>

#include "api/compare/compare.h"

namespace meshgauge::cli {

std::string to_table(const api::Comparison& comparison);

}  // namespace meshgauge::cli
