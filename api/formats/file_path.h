// The names of files beside a .gltf: relative paths that lead nowhere but into its folder. They come from a document,
// an archive or a client, so each may be an attack.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::size_t kMostFilePathBytes = 1024;
inline constexpr std::size_t kMostFilePathFolders = 32;

// A relative path of plain components with '/' between them, or why there is none.
struct FilePath {
  std::string path;    // without '.' and empty components
  std::string defect;  // behind the name in a message: "leads out of the folder"; empty: the path is good
};

// The name of an entry in an archive, where the case of ASCII letters does not count: paths of one key are one file.
std::string file_key(std::string_view path);

// Refused: an empty or absolute path, '..' anywhere, a scheme ("http:", "C:"), a backslash, a control character, more
// than 1024 bytes, more than 32 folders, and "_rels/.rels", by which an archive is told to be a package (3MF).
FilePath file_path_of_name(std::string_view name);

// The same of a URI reference in a .gltf, whose percent-encoding is decoded first. A '%' without two hex digits stands
// for itself.
FilePath file_path_of_uri(std::string_view uri);

}  // namespace meshgauge::api
