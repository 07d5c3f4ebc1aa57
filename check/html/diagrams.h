// Drawings of a report, as inline SVG. Horizontal positions are percentages, so that a drawing scales with its
// container and its letters do not.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "check/html/picture.h"
#include "check/outcome.h"
#include "check/reports/history.h"

namespace meshgauge::check {

std::string definitions();  // definitions that the other drawings use; once per document

std::string icon(Verdict verdict);  // a different shape for each verdict, so that colours are not needed

// Draws the interval against the limit. `units`: of a length; a label, may be empty.
std::string interval_drawing(const Criterion& found, const std::string& units);

// Draws the same for a line of a table, with the limit always in the middle.
std::string interval_line(const Criterion& criterion);

// Draws the interval of each run as a bar above the limit's line, the oldest on the left. Empty for fewer than two
// runs.
std::string history_drawing(const Chart& chart);

std::string histogram_drawing(const Histogram& histogram, double limit, const std::string& units);

std::string colour_bar(const api::ColourScale& scale, const std::string& units);

// Draws what lies over a picture: witness, frame of the close-up, axes and scale.
std::string overlay(const Shot& shot, const std::string& units);

// Draws a bar of this share of the whole width.
std::string share_bar(double share);

}  // namespace meshgauge::check
