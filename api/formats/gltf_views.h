// The bytes of a glTF's bufferViews, from its buffers or decompressed.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "api/formats/gltf_budget.h"
#include "api/formats/gltf_document.h"
#include "api/formats/source.h"

namespace meshgauge::api {

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
