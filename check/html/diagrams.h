// The drawings of a report, as inline SVG. Horizontal places are percents, so that drawings are as wide as their place
// and their letters keep their size.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "check/html/picture.h"
#include "check/outcome.h"

namespace meshgauge::check {

std::string definitions();  // what the other drawings refer to; once in a document

std::string icon(Verdict verdict);  // a sign of its own for each: not told apart by colours alone

// The interval against the limit. `units`: a label, may be empty.
std::string interval_drawing(const Measured& measured, const std::string& units);

// The same in the line of a table: the limit is in the middle of every one of them.
std::string interval_line(const Measured& measured);

std::string histogram_drawing(const Histogram& histogram, double limit, const std::string& units);

std::string colour_bar(const api::ColourScale& scale, const std::string& units);

// What lies over a picture: witness, frame of the close-up, axes and scale.
std::string overlay(const Shot& shot, const std::string& units);

// A bar of so much of the whole width.
std::string share_bar(double share);

}  // namespace meshgauge::check
