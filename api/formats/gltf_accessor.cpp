#include "api/formats/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace meshgauge::api {
namespace {

template <class T>
T load(const std::byte* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

// A component as the standard maps it to a real number.
template <class T>
double component(const std::byte* p, bool normalized) {
  const auto value = static_cast<double>(load<T>(p));
  if constexpr (std::is_integral_v<T>) {
    if (normalized) return std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
  }
  return value;
}

double component(const std::byte* p, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return component<std::int8_t>(p, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return component<std::uint8_t>(p, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return component<std::int16_t>(p, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return component<std::uint16_t>(p, normalized);
    default:
      return component<float>(p, false);
  }
}

// 0 for a type that POSITION cannot have.
std::size_t position_component_bytes(int type, bool quantized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return quantized ? 1 : 0;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return quantized ? 2 : 0;
    default:
      return 0;
  }
}

std::size_t index_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return 4;
    default:
      return 0;
  }
}

std::uint32_t load_index(const std::byte* p, std::size_t bytes) {
  if (bytes == 1) return load<std::uint8_t>(p);
  return bytes == 2 ? load<std::uint16_t>(p) : load<std::uint32_t>(p);
}

}  // namespace

// All numbers come from check_gltf() and are below 2^53, so that no sum or product below overflows 64 bits:
// element_bytes and stride are below 2^8.
Result<GltfAccessors::Elements> GltfAccessors::elements(std::size_t accessor, std::size_t view, std::uint64_t offset,
                                                        std::uint64_t count, std::size_t element_bytes) const {
  const std::string name = "bufferViews[" + std::to_string(view) + "]";
  if (view >= model_.bufferViews.size()) return fail(accessor, name + " does not exist");
  const tinygltf::BufferView& v = model_.bufferViews[view];
  const auto buffer = static_cast<std::size_t>(v.buffer);
  if (buffer >= buffers_.size()) {
    return fail(accessor, name + " names buffer " + std::to_string(buffer) + ", which does not exist");
  }
  if (v.byteOffset + v.byteLength > buffers_[buffer].size()) {
    return fail(accessor, name + " reaches beyond its buffer of " + std::to_string(buffers_[buffer].size()) + " bytes");
  }
  const std::size_t stride = v.byteStride != 0 ? v.byteStride : element_bytes;
  if (stride < element_bytes) {
    return fail(accessor,
                "the stride of " + name + " is less than an element of " + std::to_string(element_bytes) + " bytes");
  }
  const bool fits =
      offset <= v.byteLength && (count == 0 || (v.byteLength - offset >= element_bytes &&
                                                (v.byteLength - offset - element_bytes) / stride >= count - 1));
  if (!fits) return fail(accessor, std::to_string(count) + " elements reach beyond " + name);
  return Elements{buffers_[buffer].data() + v.byteOffset + offset, stride, static_cast<std::size_t>(count)};
}

// What has no bufferView has no bytes to be checked against, but shall not grow out of nothing either.
Result<Done> GltfAccessors::check_count(std::size_t accessor) const {
  if (accessor >= model_.accessors.size()) return fail(accessor, "does not exist");
  const tinygltf::Accessor& a = model_.accessors[accessor];
  std::size_t largest = source_.bytes.size();
  for (const auto& buffer : buffers_) largest = std::max(largest, buffer.size());
  if (a.bufferView < 0 && a.count > largest) {
    return fail(accessor, std::to_string(a.count) + " elements without a bufferView, more than the file has bytes");
  }
  if (a.sparse.isSparse && static_cast<std::size_t>(a.sparse.count) > a.count) {
    return fail(accessor, "more sparse elements than elements");
  }
  return Done{};
}

template <class T, class Decode>
Result<std::vector<T>> GltfAccessors::read(std::size_t accessor, std::size_t element_bytes,
                                           const Decode& decode) const {
  const tinygltf::Accessor& a = model_.accessors[accessor];
  std::vector<T> values;
  if (a.bufferView < 0) {
    const std::byte zeros[16] = {};
    values.resize(a.count, decode(zeros));
  } else {
    const auto found = elements(accessor, static_cast<std::size_t>(a.bufferView), a.byteOffset, a.count, element_bytes);
    if (!found) return found.error();
    values.reserve(a.count);
    for (std::size_t i = 0; i < a.count; ++i) values.push_back(decode(found->at(i)));
  }
  if (a.sparse.isSparse) {
    if (auto ok = read_sparse(accessor, element_bytes, decode, values); !ok) return std::move(ok).error();
  }
  return values;
}

template <class T, class Decode>
Result<Done> GltfAccessors::read_sparse(std::size_t accessor, std::size_t element_bytes, const Decode& decode,
                                        std::vector<T>& values) const {
  const auto& sparse = model_.accessors[accessor].sparse;
  const auto count = static_cast<std::uint64_t>(sparse.count);
  const std::size_t bytes = index_bytes(sparse.indices.componentType);
  if (bytes == 0) return fail(accessor, "sparse indices must be unsigned integers");
  const auto places = elements(accessor, static_cast<std::size_t>(sparse.indices.bufferView),
                               static_cast<std::uint64_t>(sparse.indices.byteOffset), count, bytes);
  if (!places) return places.error();
  const auto replacements = elements(accessor, static_cast<std::size_t>(sparse.values.bufferView),
                                     static_cast<std::uint64_t>(sparse.values.byteOffset), count, element_bytes);
  if (!replacements) return replacements.error();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t place = load_index(places->at(i), bytes);
    if (place >= values.size()) return fail(accessor, "sparse index " + std::to_string(place) + " is out of range");
    values[place] = decode(replacements->at(i));
  }
  return Done{};
}

Result<std::vector<Vec3>> GltfAccessors::positions(std::size_t accessor) const {
  if (auto ok = check_count(accessor); !ok) return std::move(ok).error();
  const tinygltf::Accessor& a = model_.accessors[accessor];
  if (a.type != TINYGLTF_TYPE_VEC3) return fail(accessor, "POSITION must be of type VEC3");
  const std::size_t bytes = position_component_bytes(a.componentType, quantized_);
  if (bytes == 0) {
    return fail(accessor, "POSITION must be of float components, or of 8 or 16 bits with KHR_mesh_quantization");
  }
  if (a.count > vertex_limit(source_)) return too_many(source_, "vertices", vertex_limit(source_));
  auto values = read<Vec3>(accessor, 3 * bytes, [&](const std::byte* p) {
    const auto at = [&](std::size_t k) { return component(p + k * bytes, a.componentType, a.normalized); };
    return Vec3(at(0), at(1), at(2));
  });
  if (!values) return values;
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (!(*values)[i].allFinite()) {
      return fail(accessor, "element " + std::to_string(i) + " has a coordinate that is not finite",
                  ErrorCode::non_finite_vertex);
    }
  }
  return values;
}

Result<std::vector<std::uint32_t>> GltfAccessors::indices(std::size_t accessor) const {
  if (auto ok = check_count(accessor); !ok) return std::move(ok).error();
  const tinygltf::Accessor& a = model_.accessors[accessor];
  const std::size_t bytes = index_bytes(a.componentType);
  if (a.type != TINYGLTF_TYPE_SCALAR || bytes == 0) {
    return fail(accessor, "indices must be of type SCALAR and of unsigned integers");
  }
  return read<std::uint32_t>(accessor, bytes, [bytes](const std::byte* p) { return load_index(p, bytes); });
}

}  // namespace meshgauge::api
