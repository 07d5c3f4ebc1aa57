// Writes the report as one HTML file that opens from disk, loads nothing and runs no script.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "check/html/picture.h"
#include "check/outcome.h"

namespace meshgauge::check {

// pictures[i] belongs to report.outcomes[i]; there may be fewer. Deterministic. Foreign text (names, messages, a
// service's result) is escaped, and a Content-Security-Policy forbids everything but the page's own style and inline
// pictures. Failures come first. Size: 40 kB, 10 to 30 kB for each gate, and its pictures; 3 kB for a gate without.
std::string to_html(const Report& report, std::span<const GatePicture> pictures);

// The style sheet of the report, report.css.
std::string_view report_style();

}  // namespace meshgauge::check
