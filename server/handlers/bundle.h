// A .gltf and the files that were sent beside it, on their way to be one object.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/problem.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"

namespace meshgauge::server {

struct SentFile {
  std::string path;  // relative, of plain components (api/formats/file_path.h)
  std::unique_ptr<Upload> upload;
};

struct MeshField {
  FieldHead head;
  std::unique_ptr<Upload> upload;  // null: it has not been sent
  std::vector<SentFile> files;     // that were sent beside it
};

// How many bytes the part takes with its files, in whatever form.
std::uint64_t bytes_of(const MeshField& field);

// Puts a part and its files together as one archive (api/formats/gltf_bundle.h), which replaces its upload; a part
// without files stays as it is. The document is not parsed: which of the files it names is for its reader in the
// sandbox to see. While it is written, the budget holds the largest of the files twice. Refused: files beside what is
// not JSON, an archive of more than `most` bytes or of 4 GiB, and what Upload::append() refuses.
// Precondition: all uploads are finished, and each path is there once.
std::optional<api::Problem> put_together(MeshField& field, std::uint64_t most, ByteBudget& budget,
                                         const std::string& temp_dir);

}  // namespace meshgauge::server
