// A mesh file in memory: one file, or a .gltf with the files that its buffers name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "api/whole_file.h"
#include "engine/result.h"

namespace meshgauge::api {

std::filesystem::path folder_of(const std::filesystem::path& file);  // "." where the path has none

class MeshFile {
 public:
  // Reads a regular file. A .gltf that names other files becomes one archive with them (api/formats/gltf_bundle.h):
  // they must be regular files in its folder or below, and symbolic links to them are not followed. An Error names
  // the file that is missing, refused or too large.
  static Result<MeshFile> open(const std::string& path);

  std::span<const std::byte> bytes() const { return whole_ ? whole_->bytes() : std::as_bytes(std::span(bundle_)); }

  // For a service: the media type of the bytes, and the suffix to add to the file's name ("" or ".zip").
  std::string_view media_type() const { return whole_ ? "application/octet-stream" : "application/zip"; }
  std::string_view more_suffix() const { return whole_ ? "" : ".zip"; }

 private:
  explicit MeshFile(WholeFile whole) : whole_(std::move(whole)) {}
  explicit MeshFile(std::string bundle) : bundle_(std::move(bundle)) {}

  std::optional<WholeFile> whole_;
  std::string bundle_;  // empty if there is a `whole_`
};

}  // namespace meshgauge::api
