// Escapes foreign text (names of files and gates, messages) for HTML.
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
