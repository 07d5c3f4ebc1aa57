// Sampled statistics as text for people: one line of numbers and a histogram of bars for each direction.
#pragma once

#include <string>

#include "engine/statistics.h"

namespace meshgauge::cli {

std::string to_table(const Statistics& statistics);

}  // namespace meshgauge::cli
