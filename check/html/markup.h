// Markup of the report: escapes foreign text (names of files and gates, messages) for HTML, and writes elements of
// SVG.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace meshgauge::check {

// For text and quoted attributes: & < > " ' become references. Bytes that are not UTF-8, characters that HTML forbids
// and characters that change the direction of writing become U+FFFD.
std::string escaped(std::string_view text);

std::string base64(std::span<const std::byte> bytes);
std::string sha256_base64(
    std::string_view text);  // in the form in which a Content-Security-Policy names an inline style

}  // namespace meshgauge::check

namespace meshgauge::check::svg {

std::string percent(double share);  // "12.34%"; share within [0, 1]
std::string number(double x);       // two decimals; 0 if not finite

std::string label(std::string_view css_class, double share, int y, const std::string& plain_text);
std::string line(std::string_view css_class, double share, int y1, int y2);  // vertical
std::string box(std::string_view css_class, double from, double to, int y,
                int height);  // between two shares of the width
std::string cased_line(double x1, double y1, double x2, double y2,
                       std::string_view css_class);  // visible on any background

// Returns the largest round length (1, 2 or 5 times a power of ten) that is at most `most`; 0: there is none.
double round_length(double most);

}  // namespace meshgauge::check::svg
