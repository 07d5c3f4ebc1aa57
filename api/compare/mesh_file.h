// A mesh file in memory: one file, a .gltf with the files that its buffers name, or what a pipe sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/byte_budget.h"
#include "api/base/memory_file.h"
#include "api/base/roots.h"
#include "api/base/whole_file.h"
#include "api/formats/format.h"
#include "engine/result.h"

namespace meshgauge::api {

std::filesystem::path folder_of(const std::filesystem::path& file);  // "." where the path has none

// What pipes sent, by the name that each has in messages: a pipe is read once, and opened here as often as a file.
using Pipes = std::map<std::string, MemoryFile>;

// What may be read for a client that is not trusted.
struct Confines {
  Roots roots;
  ReadLimits limits = kUntrustedLimits;
  std::uint64_t max_file_bytes = kUntrustedFileBytes;
  // What all files that are held at the same time, or whose meshes are, may have together; null: any number of bytes.
  std::shared_ptr<ByteBudget> files{};
};

// Paths of files that stand in place of others, by the names that those have in messages.
using Copies = std::map<std::string, std::string>;

class MeshFile {
 public:
  // Reads a regular file. A .gltf that names other files becomes one archive with them
  // (api/formats/gltf/gltf_bundle.h): they must be regular files in its folder or below, and symbolic links to them are
  // not followed. An Error names the file that is missing, refused or too large. A path that is the name of one of
  // `pipes`, which are borrowed, is what that pipe sent; it has no folder, so a .gltf that names other files is refused
  // there. A path that is a name of `copies`, which are borrowed, too, is that file.
  static Result<MeshFile> open(const std::string& path, const Pipes* pipes = nullptr, const Copies* copies = nullptr);

  // As open(), of a file that the roots find (Roots::find). No symbolic link below a root is followed. Errors also:
  // those of Roots::find(); too_large above max_file_bytes, of a .gltf with the files that it names,
  // and when the other files that are held leave no room.
  static Result<MeshFile> open_within(const Confines& confines, const std::string& path);

  std::span<const std::byte> bytes() const {
    if (!bundle_.empty()) return std::as_bytes(std::span(bundle_));
    return whole_ ? whole_->bytes() : piped_;
  }

  // Keep them as long as what was made of the bytes.
  const std::vector<ByteBudget::Lease>& leases() const { return leases_; }

  // For a service: the media type of the bytes, and the suffix to add to the file's name ("" or ".zip").
  std::string_view media_type() const { return bundle_.empty() ? "application/octet-stream" : "application/zip"; }
  std::string_view more_suffix() const { return bundle_.empty() ? "" : ".zip"; }

 private:
  explicit MeshFile(WholeFile whole) : whole_(std::move(whole)) {}
  explicit MeshFile(std::string bundle) : bundle_(std::move(bundle)) {}
  explicit MeshFile(std::span<const std::byte> piped) : piped_(piped) {}

  // `path`: in messages. `folder`, `before`: where the files are that a .gltf names, folder/ + before + name. `most`:
  // bytes of all of them.
  static Result<MeshFile> of_file(const std::string& path, WholeFile whole, const BaseFolder& folder,
                                  const std::string& before, std::uint64_t most);
  static Result<MeshFile> of_pipe(const std::string& name, std::span<const std::byte> bytes);

  // Takes the bytes from the budget for files, if there is one. `path`: in the message.
  static Result<ByteBudget::Lease> lease(const Confines& confines, std::uint64_t bytes, const std::string& path);

  std::vector<ByteBudget::Lease> leases_;
  std::optional<WholeFile> whole_;
  std::string bundle_;  // empty: it is no bundle
  std::span<const std::byte> piped_;
};

}  // namespace meshgauge::api
