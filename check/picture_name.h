// Names of the files of a gate's pictures.
#pragma once

#include <string>

namespace meshgauge::check {

// Returns "bracket.png" for the gate "bracket". A name that has other characters than lower-case letters, digits, '-',
// '_' and '.', or is longer than 72 of them, or begins or ends with one that is no letter and no digit, or ends as such
// a file does, is shortened to those, with the beginning of its digest: "part-a-83d2558d4bdc274a.png". So no two gates
// of a run share a file, also where upper and lower case are one, and no name leads into another folder.
std::string picture_name(const std::string& gate);

}  // namespace meshgauge::check
