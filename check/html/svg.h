// Helpers that write SVG.
#pragma once

#include <string>
#include <string_view>

namespace meshgauge::check::svg {

std::string percent(double share);  // "12.34%"; share within [0, 1]
std::string number(double x);       // two decimals; 0 if not finite

// Text anchor for a label at `share` of the width that keeps it inside: "start", "middle" or "end".
std::string_view anchor(double share);

std::string label(std::string_view css_class, double share, int y, const std::string& plain_text);
std::string line(std::string_view css_class, double share, int y1, int y2);  // vertical
std::string box(std::string_view css_class, double from, double to, int y,
                int height);  // between two shares of the width
std::string cased_line(double x1, double y1, double x2, double y2,
                       std::string_view css_class);  // visible on any background

// Returns the largest round length (1, 2 or 5 times a power of ten) that is at most `most`; 0: there is none.
double round_length(double most);

}  // namespace meshgauge::check::svg
