// Accessors of a glTF: every offset, stride and count is checked in 64 bits before a byte is read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <tiny_gltf.h>

#include "api/formats/source.h"

namespace meshgauge::api {

class GltfAccessors {
 public:
  // Borrows all of it. `quantized`: positions may be integers, by KHR_mesh_quantization.
  GltfAccessors(const Source& source, const tinygltf::Model& model, std::span<const std::span<const std::byte>> buffers,
                bool quantized)
      : source_(source), model_(model), buffers_(buffers), quantized_(quantized) {}

  // VEC3 of float (or quantized), sparse or not, all finite; without a bufferView all zero, as the standard has it.
  Result<std::vector<Vec3>> positions(std::size_t accessor) const;

  // SCALAR of unsigned integers.
  Result<std::vector<std::uint32_t>> indices(std::size_t accessor) const;

 private:
  // Elements in a buffer, `stride` bytes apart.
  struct Elements {
    const std::byte* first = nullptr;
    std::size_t stride = 0;
    std::size_t count = 0;
    const std::byte* at(std::size_t i) const { return first + i * stride; }
  };

  template <class T, class Decode>
  Result<std::vector<T>> read(std::size_t accessor, std::size_t element_bytes, const Decode& decode) const;
  template <class T, class Decode>
  Result<Done> read_sparse(std::size_t accessor, std::size_t element_bytes, const Decode& decode,
                           std::vector<T>& values) const;
  Result<Elements> elements(std::size_t accessor, std::size_t view, std::uint64_t offset, std::uint64_t count,
                            std::size_t element_bytes) const;
  Result<Done> check_count(std::size_t accessor) const;
  Error fail(std::size_t accessor, const std::string& what, ErrorCode code = ErrorCode::unreadable_mesh) const {
    return meshgauge::api::at(source_, "accessors[" + std::to_string(accessor) + "]", code, what);
  }

  const Source& source_;
  const tinygltf::Model& model_;
  std::span<const std::span<const std::byte>> buffers_;
  bool quantized_;
};

}  // namespace meshgauge::api
