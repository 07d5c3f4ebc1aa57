// The style sheet of the HTML report, report.css.
#pragma once

#include <string_view>

namespace meshgauge::check {

std::string_view report_style();

}  // namespace meshgauge::check
