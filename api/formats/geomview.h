// Recognises the objects of Geomview other than OFF, to refuse them by name.
#pragma once

#include <string_view>

namespace meshgauge::api {

// Returns the word of another object at the start of a text without leading blanks and comments: "LIST", "CMESH",
// "BEZ133", "appearance"; "{" for an object in braces, but not for a JSON object. Empty: none. Constant time, except
// for the spaces and comments after a brace.
std::string_view geomview_object(std::string_view text);

}  // namespace meshgauge::api
