// Combines an uploaded .gltf and the files sent beside it into one archive.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/base/problem.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"

namespace meshgauge::server {

struct SentFile {
  std::string path;  // relative, without '.' and '..' (api/formats/file/file_path.h)
  std::unique_ptr<Upload> upload;
};

// A mesh of the form, with the files that belong to it.
struct MeshField {
  FieldHead head;
  std::unique_ptr<Upload> upload;  // null: not sent
  std::vector<SentFile> files;     // sent as a.files or b.files
};

// Returns the size of the mesh's upload and its files together.
std::uint64_t bytes_of(const MeshField& field);

// Replaces the upload of a mesh that has files by one archive of all of them (api/formats/gltf/gltf_bundle.h); a mesh
// without files stays as it is. The document is not parsed here: its reader in the sandbox checks which files it names.
// While the archive is written, the budget counts the largest file twice.
//
// Returns a problem if the mesh is not a JSON document, if the archive is larger than `most` bytes or 4 GiB, or if
// Upload::append() returns one. Precondition: all uploads are finished, and their paths differ.
std::optional<api::Problem> combine_files(MeshField& field, std::uint64_t most, const UploadShare& share,
                                          const std::string& temp_dir);

}  // namespace meshgauge::server
