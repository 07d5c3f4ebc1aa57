// The bytes of a glTF's bufferViews, from its buffers or decompressed, and what reading it may cost.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_document.h"

namespace meshgauge::api {

// Limits the cost of reading one glTF by the size sent: of the file, or of the archive with the files beside it.
class GltfBudget {
 public:
  // Borrows `sent`, the file or the archive; its size sets the limits. Buffers that share bytes and entries that an
  // archive expands do not raise them.
  explicit GltfBudget(const Source& sent);

  // Charges bytes that compressed parts expand to; bytes decompressed twice count twice. Error: too_large once their
  // sum exceeds expansion_limit().
  Result<Done> take(std::size_t bytes);

  // Returns true when elements without bytes in the file may temporarily take so much memory.
  bool fits(std::size_t bytes) const { return bytes <= most_bytes_; }

  // Charges steps of a few nanoseconds each: an element read, a corner placed. Error, naming `where`: their sum exceeds
  // kFreeSteps + kStepsPerByte * bytes sent. Nodes, instances, primitives and targets of a small file may read its few
  // numbers millions of times.
  Result<Done> work(std::size_t steps, const std::string& where);

  // Refunds up to kStepsPerTriangle for each triangle added to the mesh since steps() was `since`: max_triangles
  // already bounds that work.
  void refund(std::size_t since, std::size_t triangles);

  std::size_t steps() const { return steps_; }

  static constexpr std::size_t kFreeSteps = std::size_t{1} << 27;
  static constexpr std::size_t kStepsPerByte = 16;
  static constexpr std::size_t kStepsPerTriangle = 32;

 private:
  const Source& sent_;
  std::size_t most_bytes_;
  std::size_t most_steps_;
  std::size_t bytes_ = 0;
  std::size_t steps_ = 0;
};

class GltfViews {
 public:
  // Borrows its arguments.
  GltfViews(const Source& source, const tinygltf::Model& model, const GltfDocument& document,
            std::span<const std::span<const std::byte>> buffers, GltfBudget& budget)
      : source_(source), model_(model), document_(document), buffers_(buffers), budget_(budget) {}

  // Returns the bytes of a view, valid as long as this object. Decompresses a view once. `where`: the place that names
  // the view, for messages.
  Result<std::span<const std::byte>> bytes(std::size_t view, const std::string& where);

  // Returns the stride in bytes of a view compressed by meshopt; nullopt: it is not compressed.
  std::optional<std::size_t> meshopt_stride(std::size_t view) const {
    const auto found = document_.meshopt.find(view);
    return found == document_.meshopt.end() ? std::nullopt : std::optional<std::size_t>(found->second.stride);
  }

  // Returns the byteStride that the file gives an existing view; nullopt: none.
  std::optional<std::size_t> stride(std::size_t view) const { return document_.strides[view]; }

  // Counts a view whose elements lie where glTF does not allow them, once.
  void add_odd(std::size_t view) { odd_.insert(view); }
  std::size_t odd() const { return odd_.size(); }

  GltfBudget& budget() const { return budget_; }
  std::size_t decompressed() const { return decompressed_.size(); }  // number of views decompressed so far

 private:
  Result<std::span<const std::byte>> piece(const std::string& where, const std::string& what, std::size_t buffer,
                                           std::size_t offset, std::size_t length) const;
  Result<std::vector<std::byte>> decompress(std::size_t view, const GltfMeshopt& meshopt);

  const Source& source_;
  const tinygltf::Model& model_;
  const GltfDocument& document_;
  std::span<const std::span<const std::byte>> buffers_;
  GltfBudget& budget_;
  std::map<std::size_t, std::vector<std::byte>> decompressed_;
  std::set<std::size_t> odd_;
};

}  // namespace meshgauge::api
