// The naming rule: what stands in braces in a gate's name and baseline, filled in for each file that its candidate
// finds.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace meshgauge::check {

// Of "build/lod/near/part.glb.gz", found by "build/lod/**/*.glb.gz":
struct NameParts {
  std::string stem;  // "part": without suffix, and without the ".gz" of a compressed file
  std::string name;  // "part.glb.gz"
  std::string dir;   // "near": the folder, below what stands before the first wildcard; empty: there is none
};

NameParts name_parts(std::string_view file_name, std::string dir);

// ".stl.gz" of "part.v2.STL.gz": in lower case, and with what stands before the ".gz" of a compressed file.
std::string suffix_of(const std::filesystem::path& file);

// A placeholder that is not known, a brace without its partner: what is wrong, behind the subject ("has ...").
Result<Done> check_template(std::string_view text);
bool has_placeholder(std::string_view text);

// Precondition: check_template() has no objection. "{dir}/" is left out when there is no such folder; "{dir}" is then
// ".".
std::string filled(std::string_view text, const NameParts& parts);

}  // namespace meshgauge::check
