// Text that comes from outside, names of files and gates and messages, as HTML that shows it and does nothing else.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace meshgauge::check {

// For text and for attributes in quotes: & < > " ' are written as references. What is not UTF-8, or is a character that
// HTML forbids (most control characters), becomes U+FFFD, as do those that turn the direction of writing: nothing that
// follows a name may read otherwise because of it.
std::string escaped(std::string_view text);

std::string base64(std::span<const std::byte> bytes);
std::string sha256_base64(std::string_view text);  // as a Content-Security-Policy names an inline style

}  // namespace meshgauge::check
