// Fills in the placeholders of a gate's name and baseline for each file that its candidate's glob finds.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace meshgauge::check {

// The parts of "build/lod/near/part.glb.gz", found by "build/lod/**/*.glb.gz":
struct NameParts {
  std::string stem;  // "part": without suffix, and without the ".gz" of a compressed file
  std::string name;  // "part.glb.gz"
  std::string dir;   // "near": the folder, below what stands before the first wildcard; empty: there is none
};

NameParts name_parts(std::string_view file_name, std::string dir);

// Returns the suffix in lower case; before ".gz" the inner one as well: ".stl.gz" for "part.v2.STL.gz".
std::string suffix_of(const std::filesystem::path& file);

// Checks the braces of a template. The Error is the end of a sentence ("has ...") about an unknown placeholder or an
// unmatched brace.
Result<Done> check_template(std::string_view text);
bool has_placeholder(std::string_view text);

// Fills in the placeholders. An empty "{dir}/" is left out; an empty "{dir}" becomes ".". Precondition:
// check_template() accepts the text.
std::string filled(std::string_view text, const NameParts& parts);

}  // namespace meshgauge::check
