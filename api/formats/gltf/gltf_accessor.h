// Reads the accessors of a glTF. Every offset, stride and count is checked in 64 bits before a byte is read.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <tiny_gltf.h>

#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_views.h"
#include "engine/mesh/large_array.h"

namespace meshgauge::api {

// An attribute decoded by Draco; replaces the bytes of its accessor.
struct GltfColumn {
  int component_type = 0;  // as for an accessor
  std::size_t components = 0;
  std::size_t count = 0;
  std::vector<std::byte> bytes;  // tightly packed
};

class GltfAccessors {
 public:
  // Borrows its arguments. `quantized`: positions may be integers (KHR_mesh_quantization).
  GltfAccessors(const Source& source, const tinygltf::Model& model, GltfViews& views, bool quantized)
      : source_(source), model_(model), views_(views), quantized_(quantized) {}

  // All functions below take sparse accessors as well, return zeros for an accessor without a bufferView (glTF 2.0),
  // and return finite numbers only. A `column` that is not nullptr replaces the accessor's bytes.

  // Reads VEC3 of float (or quantized). `name`: the attribute in messages, "POSITION".
  Result<std::vector<Vec3>> positions(std::size_t accessor, std::string_view name,
                                      const GltfColumn* column = nullptr) const;
  // Reads VEC3 of float, for attributes that KHR_mesh_quantization does not allow to be integers.
  Result<std::vector<Vec3>> floats(std::size_t accessor, std::string_view name) const;
  // Reads VEC4 of float or normalized signed integers: quaternions, x y z w.
  Result<std::vector<Eigen::Vector4d>> rotations(std::size_t accessor) const;
  // Reads VEC4 of float or normalized unsigned integers.
  Result<std::vector<Eigen::Vector4d>> weights(std::size_t accessor, const GltfColumn* column = nullptr) const;
  // Reads VEC4 of unsigned integers of 8 or 16 bits.
  Result<std::vector<std::array<std::uint32_t, 4>>> joints(std::size_t accessor,
                                                           const GltfColumn* column = nullptr) const;
  // Reads MAT4 of float: only the first `most`, since there may be more than are used.
  Result<std::vector<Eigen::Matrix4d>> matrices(std::size_t accessor, std::size_t most) const;

  // Reads SCALAR of unsigned integers.
  Result<LargeArray<std::uint32_t>> indices(std::size_t accessor) const;

 private:
  // Elements in a buffer, `stride` bytes apart.
  struct Elements {
    const std::byte* first = nullptr;
    std::size_t stride = 0;
    std::size_t count = 0;
    const std::byte* at(std::size_t i) const { return first + i * stride; }
  };

  // The type and component types that a use of an accessor allows.
  struct Use {
    int type;
    bool (*allows)(int component_type, bool normalized);
    std::string expected;  // for messages: "POSITION must be of type VEC3 and of float components"
    bool strided = true;   // as for Element
  };

  // Sizes in bytes. `strided`: glTF allows a byteStride, as it does for attributes alone.
  struct Element {
    std::size_t bytes;
    std::size_t component;
    bool strided;
  };

  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  template <int N>
  Result<std::vector<Eigen::Matrix<double, N, 1>>> vectors(std::size_t accessor, const Use& use,
                                                           const GltfColumn* column, std::size_t most = kAll) const;
  template <class Values, class Decode>
  Result<Values> read(std::size_t accessor, std::size_t most, const Element& element, const Decode& decode,
                      const GltfColumn* column) const;
  template <class Values, class Decode>
  Result<Done> read_sparse(std::size_t accessor, const Element& element, const Decode& decode, Values& values) const;
  Result<Elements> elements(std::size_t accessor, std::size_t view, std::uint64_t offset, std::uint64_t count,
                            const Element& element) const;
  bool is_odd(std::size_t view, std::uint64_t offset, const Element& element) const;
  Result<Done> check_count(std::size_t accessor, const GltfColumn* column) const;
  Error of_another_type(std::size_t accessor, const std::string& expected, int component_type) const;
  Result<Done> work(std::size_t accessor, std::size_t steps) const {
    return views_.budget().work(steps, "accessors[" + std::to_string(accessor) + "]");
  }
  Error fail(std::size_t accessor, const std::string& what, ErrorCode code = ErrorCode::unreadable_mesh) const {
    return meshgauge::api::at(source_, "accessors[" + std::to_string(accessor) + "]", code, what);
  }

  const Source& source_;
  const tinygltf::Model& model_;
  GltfViews& views_;
  bool quantized_;
};

}  // namespace meshgauge::api
