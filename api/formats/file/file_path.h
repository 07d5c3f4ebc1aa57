// Checks the names of files beside a .gltf: relative paths within its folder. They come from a document, an archive or
// a client and are not trusted.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::size_t kMostFilePathBytes = 1024;
inline constexpr std::size_t kMostFilePathFolders = 32;

// A relative path of plain components separated by '/', or the reason why there is none.
struct FilePath {
  std::string path;    // without '.' and empty components
  std::string defect;  // follows the name in a message: "names a folder"; empty: the path is valid
};

// Returns the path in lower case (ASCII), as for names in archives: paths with the same key are the same file.
std::string file_key(std::string_view path);

// Checks a file name. Refuses an empty or absolute path, '..' anywhere, a scheme ("http:", "C:"), a backslash, a
// control character, more than 1024 bytes, more than 32 folders, and "_rels/.rels", which would mark an archive as a
// 3MF.
FilePath file_path_of_name(std::string_view name);

// Decodes the percent-encoding of a URI reference in a .gltf, then checks the result like a file name. A '%' without
// two hex digits stands for itself.
FilePath file_path_of_uri(std::string_view uri);

}  // namespace meshgauge::api
