// A mesh file on its way through read_mesh(), and what must hold of every answer.
#pragma once

#include <string_view>

namespace meshgauge::fuzz {

// Reads the file under this name. Asserted:
//   * a refusal names the part and is no internal failure;
//   * what is accepted passes validate(); every index is in range, every coordinate finite, also of vertices that no
//     triangle uses; the counts are within the limits, and within the bytes where nothing is compressed or instanced;
//   * the same bytes give the same answer again, and under another name, where the content tells the format;
//   * the format told is that of detect_format().
void check_mesh_file(std::string_view file, std::string_view filename);

// The same for a file of one format, "obj": anything that another target is for is passed over.
void check_file_of(std::string_view format, std::string_view file);

// The file in gzip: the same answer as without; and with one byte changed, a refusal or the same answer.
void check_compressed(std::string_view file);

}  // namespace meshgauge::fuzz
