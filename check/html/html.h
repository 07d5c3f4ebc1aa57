// The report as one HTML file: opens from disk, asks for nothing from anywhere, runs no script.
#pragma once

#include <span>
#include <string>

#include "check/html/picture.h"
#include "check/outcome.h"

namespace meshgauge::check {

// pictures[i] belongs to report.outcomes[i]; there may be fewer, or none at all. Deterministic. What comes from outside
// (names, messages, a service's result) is escaped; a Content-Security-Policy forbids everything but the page's own
// style and the pictures inside of it. Failures come first. Size: 40 kB, 10 to 30 kB a gate, and its pictures;
// 3 kB a gate that was left out of them.
std::string to_html(const Report& report, std::span<const GatePicture> pictures);

}  // namespace meshgauge::check
