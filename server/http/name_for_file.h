// Recognises a field of a form that holds the name of a file in place of the file: `curl -F a=part.stl` without the
// '@'.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/base/problem.h"

namespace meshgauge::server {

// Returns the problem of a field whose content is one line of text that ends as the name of a file does, or begins with
// '@', '/', './', '../' or '~/', but not with 'solid ' as an ASCII STL. nullopt: it is something else.
std::optional<api::Problem> refuse_name_for_file(const std::string& field, std::string_view content);

}  // namespace meshgauge::server
