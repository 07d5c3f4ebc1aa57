// Numbers and points as text for people.
#pragma once

#include <string>

#include "api/base/figures.h"
#include "api/base/text.h"

namespace meshgauge::check {

using api::grouped;
using api::in_bytes;
using api::in_time;
using api::in_words;
using api::IntervalText;
using api::percent_encoded;
using api::shortest;
using api::to_digits;
using api::to_digits_above;
using api::to_digits_below;
using api::trimmed;

// Rounds to `digits` significant digits, for tables.
std::string rounded(double x, int digits = 6);

}  // namespace meshgauge::check
