#include "api/formats/gltf/gltf_accessor.h"

#include <algorithm>
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

// Converts a component to a real number, as glTF defines it.
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

// Returns the number of components; 0: not a type that is read here.
std::size_t component_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    default:
      return 0;
  }
}

bool is_float(int type, bool /*normalized*/) { return type == TINYGLTF_COMPONENT_TYPE_FLOAT; }
bool is_quantized(int type, bool /*normalized*/) { return component_bytes(type) != 0; }
bool is_signed_fraction(int type, bool normalized) {
  return is_float(type, normalized) ||
         (normalized && (type == TINYGLTF_COMPONENT_TYPE_BYTE || type == TINYGLTF_COMPONENT_TYPE_SHORT));
}
bool is_unsigned_fraction(int type, bool normalized) {
  return is_float(type, normalized) || (normalized && (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                                                       type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT));
}
bool is_joint(int type, bool normalized) {
  if (normalized) return false;
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
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

template <class Vector>
bool all_finite(const std::vector<Vector>& values) {
  Vector nothing = Vector::Zero();  // stays zero, unless a component is NaN or infinite
  for (const Vector& value : values) nothing += value * 0.0;
  return nothing.isZero(0);
}

std::uint32_t load_index(const std::byte* p, std::size_t bytes) {
  if (bytes == 1) return load<std::uint8_t>(p);
  return bytes == 2 ? load<std::uint16_t>(p) : load<std::uint32_t>(p);
}

}  // namespace

// Returns whether the elements of an accessor lie where glTF does not allow them.
bool GltfAccessors::is_odd(std::size_t view, std::uint64_t offset, const Element& element) const {
  const auto stride = views_.stride(view);
  const std::size_t before = views_.meshopt_stride(view) ? 0 : model_.bufferViews[view].byteOffset;
  if ((before + offset) % element.component != 0 || offset % element.component != 0) return true;
  if (!element.strided) return stride.has_value();
  return offset % 4 != 0 || (stride && (*stride % 4 != 0 || *stride < 4 || *stride > 252));
}

// No sum or product below overflows 64 bits: all numbers come from check_gltf() and are below 2^53; the bytes of an
// element are below 2^8.
Result<GltfAccessors::Elements> GltfAccessors::elements(std::size_t accessor, std::size_t view, std::uint64_t offset,
                                                        std::uint64_t count, const Element& element) const {
  const auto bytes = views_.bytes(view, "accessors[" + std::to_string(accessor) + "]");
  if (!bytes) return bytes.error();
  const std::string name = "bufferViews[" + std::to_string(view) + "]";
  const auto fits = [&](std::size_t stride) {
    return offset <= bytes->size() && (count == 0 || (bytes->size() - offset >= element.bytes &&
                                                      (bytes->size() - offset - element.bytes) / stride >= count - 1));
  };
  std::size_t stride = views_.stride(view).value_or(0);
  if (stride == 0) stride = element.bytes;
  if (stride < element.bytes) {
    return fail(accessor, name + " has a byteStride of " + std::to_string(stride) + ", less than the " +
                              std::to_string(element.bytes) + " bytes of an element");
  }
  if (!element.strided && stride != element.bytes) {
    // Some programs read them side by side, some byteStride apart.
    if (count > 1 && fits(stride)) {
      return fail(accessor,
                  name + " has a byteStride of " + std::to_string(stride) +
                      ", which glTF allows for attributes alone: elements of " + std::to_string(element.bytes) +
                      " bytes may lie side by side or that far apart; save the model without this byteStride");
    }
    stride = element.bytes;
  }
  if (const auto packed = views_.meshopt_stride(view); packed && count > 1 && *packed != stride) {
    return fail(accessor, name + " holds elements " + std::to_string(*packed) +
                              " bytes apart by its compression, and " + std::to_string(stride) +
                              " bytes apart by its byteStride; both must be the same");
  }
  if (!fits(stride)) {
    return fail(accessor, std::to_string(count) + " elements reach beyond " + name + " of " +
                              std::to_string(bytes->size()) + " bytes");
  }
  if (is_odd(view, offset, element)) views_.add_odd(view);
  return Elements{bytes->data() + offset, stride, static_cast<std::size_t>(count)};
}

Result<Done> GltfAccessors::check_count(std::size_t accessor, const GltfColumn* column) const {
  if (accessor >= model_.accessors.size()) {
    return fail(accessor, "does not exist; the file has " + std::to_string(model_.accessors.size()) + " accessors");
  }
  const tinygltf::Accessor& a = model_.accessors[accessor];
  if (column != nullptr && column->count != a.count) {
    return fail(accessor, "count is " + std::to_string(a.count) + ", but the Draco stream holds " +
                              std::to_string(column->count) + " points");
  }
  if (column != nullptr && a.sparse.isSparse) {
    return fail(accessor, "is both sparse and compressed by Draco; save the model without one of them");
  }
  if (a.sparse.isSparse && static_cast<std::size_t>(a.sparse.count) > a.count) {
    return fail(accessor, std::to_string(a.sparse.count) + " sparse elements, but only " + std::to_string(a.count) +
                              " elements that they could replace");
  }
  return Done{};
}

// `component_type`: the one found, in the accessor or in the decoded Draco attribute.
Error GltfAccessors::of_another_type(std::size_t accessor, const std::string& expected, int component_type) const {
  const tinygltf::Accessor& a = model_.accessors[accessor];
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
  return fail(accessor, expected + "; it has " + std::to_string(std::max(components, 0)) +
                            (a.normalized ? " normalized" : "") + " components of componentType " +
                            std::to_string(component_type));
}

// `Values`: a vector whose resize() leaves the elements uninitialised.
template <class Values, class Decode>
Result<Values> GltfAccessors::read(std::size_t accessor, std::size_t most, const Element& element, const Decode& decode,
                                   const GltfColumn* column) const {
  const tinygltf::Accessor& a = model_.accessors[accessor];
  const std::size_t count = std::min(a.count, most);
  Values values;
  if (column != nullptr) {
    if (auto ok = work(accessor, column->count); !ok) return std::move(ok).error();
    values.reserve(column->count);
    for (std::size_t i = 0; i < column->count; ++i) values.push_back(decode(&column->bytes[i * element.bytes]));
    return values;
  }
  if (a.bufferView < 0) {
    // There are no bytes to check the count against, so the budget limits it.
    if (!views_.budget().fits(count * sizeof(typename Values::value_type))) {
      return fail(accessor, std::to_string(count) +
                                " elements without a bufferView, more than the limit for a file of this size");
    }
    if (auto ok = work(accessor, count); !ok) return std::move(ok).error();
    const std::byte zeros[64] = {};
    values.resize(count, decode(zeros));
  } else {
    const auto found = elements(accessor, static_cast<std::size_t>(a.bufferView), a.byteOffset, a.count, element);
    if (!found) return found.error();
    if (auto ok = work(accessor, count); !ok) return std::move(ok).error();
    reserve_room(values, count);
    values.resize(count);
    auto* const to = values.data();
    for (std::size_t i = 0; i < count; ++i) to[i] = decode(found->at(i));
  }
  if (a.sparse.isSparse) {
    if (auto ok = read_sparse(accessor, element, decode, values); !ok) return std::move(ok).error();
  }
  return values;
}

template <class Values, class Decode>
Result<Done> GltfAccessors::read_sparse(std::size_t accessor, const Element& element, const Decode& decode,
                                        Values& values) const {
  const auto& sparse = model_.accessors[accessor].sparse;
  const auto count = static_cast<std::uint64_t>(sparse.count);
  const std::size_t bytes = index_bytes(sparse.indices.componentType);
  if (bytes == 0) {
    return fail(accessor, "sparse indices must be unsigned integers, not of componentType " +
                              std::to_string(sparse.indices.componentType));
  }
  if (auto ok = work(accessor, count); !ok) return ok;
  const auto places =
      elements(accessor, static_cast<std::size_t>(sparse.indices.bufferView),
               static_cast<std::uint64_t>(sparse.indices.byteOffset), count, Element{bytes, bytes, false});
  if (!places) return places.error();
  const auto replacements = elements(accessor, static_cast<std::size_t>(sparse.values.bufferView),
                                     static_cast<std::uint64_t>(sparse.values.byteOffset), count,
                                     Element{element.bytes, element.component, false});
  if (!replacements) return replacements.error();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t place = load_index(places->at(i), bytes);
    const std::size_t all = model_.accessors[accessor].count;
    if (place >= all) {
      return fail(accessor, "sparse index " + std::to_string(place) + " at place " + std::to_string(i) +
                                ", but there are " + std::to_string(all) + " elements");
    }
    if (place < values.size()) values[place] = decode(replacements->at(i));
  }
  return Done{};
}

template <int N>
Result<std::vector<Eigen::Matrix<double, N, 1>>> GltfAccessors::vectors(std::size_t accessor, const Use& use,
                                                                        const GltfColumn* column,
                                                                        std::size_t most) const {
  using Vector = Eigen::Matrix<double, N, 1>;
  if (auto ok = check_count(accessor, column); !ok) return std::move(ok).error();
  const tinygltf::Accessor& a = model_.accessors[accessor];
  const int type = column == nullptr ? a.componentType : column->component_type;
  const bool has_components = column == nullptr || column->components == N;
  if (a.type != use.type || !has_components || !use.allows(type, a.normalized)) {
    return of_another_type(accessor, use.expected, type);
  }
  if (a.normalized && type != a.componentType) {
    return fail(accessor, "is normalized and of componentType " + std::to_string(a.componentType) +
                              ", but the Draco stream holds componentType " + std::to_string(type));
  }
  if (a.count > vertex_limit(source_)) return too_many(source_, "vertices", vertex_limit(source_));
  const std::size_t bytes = component_bytes(type);
  const auto decode = [&, normalized = a.normalized](const std::byte* p) {
    Vector out;
    for (int k = 0; k < N; ++k) out[k] = component(p + static_cast<std::size_t>(k) * bytes, type, normalized);
    return out;
  };
  const auto decode_floats = [](const std::byte* p) {
    const auto floats = load<std::array<float, std::size_t{N}>>(p);
    return Vector(Eigen::Map<const Eigen::Matrix<float, N, 1>>(floats.data()).template cast<double>());
  };
  const Element element{N * bytes, bytes, use.strided};
  auto values = is_float(type, false) ? read<std::vector<Vector>>(accessor, most, element, decode_floats, column)
                                      : read<std::vector<Vector>>(accessor, most, element, decode, column);
  if (!values || all_finite(*values)) return values;
  std::size_t i = 0;
  while ((*values)[i].allFinite()) ++i;
  return fail(accessor, "element " + std::to_string(i) + " has a coordinate that is not finite",
              ErrorCode::non_finite_vertex);
}

Result<std::vector<Vec3>> GltfAccessors::positions(std::size_t accessor, std::string_view name,
                                                   const GltfColumn* column) const {
  const std::string expected =
      std::string(name) +
      " must be of type VEC3 and of float components, or of 8 or 16 bits with KHR_mesh_quantization";
  return vectors<3>(accessor, {TINYGLTF_TYPE_VEC3, quantized_ ? is_quantized : is_float, expected}, column);
}

Result<std::vector<Vec3>> GltfAccessors::floats(std::size_t accessor, std::string_view name) const {
  return vectors<3>(accessor,
                    {TINYGLTF_TYPE_VEC3, is_float, std::string(name) + " must be of type VEC3 and of float components"},
                    nullptr);
}

Result<std::vector<Eigen::Vector4d>> GltfAccessors::rotations(std::size_t accessor) const {
  const Use use{TINYGLTF_TYPE_VEC4, is_signed_fraction,
                "ROTATION must be of type VEC4 and of float or normalized signed components"};
  return vectors<4>(accessor, use, nullptr);
}

Result<std::vector<Eigen::Vector4d>> GltfAccessors::weights(std::size_t accessor, const GltfColumn* column) const {
  const Use use{TINYGLTF_TYPE_VEC4, is_unsigned_fraction,
                "WEIGHTS must be of type VEC4 and of float or normalized unsigned components"};
  return vectors<4>(accessor, use, column);
}

Result<std::vector<std::array<std::uint32_t, 4>>> GltfAccessors::joints(std::size_t accessor,
                                                                        const GltfColumn* column) const {
  const Use use{TINYGLTF_TYPE_VEC4, is_joint, "JOINTS must be of type VEC4 and of unsigned components of 8 or 16 bits"};
  const auto read = vectors<4>(accessor, use, column);
  if (!read) return read.error();
  std::vector<std::array<std::uint32_t, 4>> out(read->size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) out[i][k] = static_cast<std::uint32_t>((*read)[i][static_cast<int>(k)]);
  }
  return out;
}

Result<std::vector<Eigen::Matrix4d>> GltfAccessors::matrices(std::size_t accessor, std::size_t most) const {
  const Use use{TINYGLTF_TYPE_MAT4, is_float, "inverseBindMatrices must be of type MAT4 and of float components",
                false};
  const auto read = vectors<16>(accessor, use, nullptr, most);
  if (!read) return read.error();
  std::vector<Eigen::Matrix4d> out;
  out.reserve(read->size());
  for (const auto& columns : *read) out.emplace_back(Eigen::Map<const Eigen::Matrix4d>(columns.data()));
  return out;
}

Result<LargeArray<std::uint32_t>> GltfAccessors::indices(std::size_t accessor) const {
  if (auto ok = check_count(accessor, nullptr); !ok) return std::move(ok).error();
  const tinygltf::Accessor& a = model_.accessors[accessor];
  const std::size_t bytes = index_bytes(a.componentType);
  if (a.type != TINYGLTF_TYPE_SCALAR || bytes == 0) {
    return of_another_type(accessor, "indices must be of type SCALAR and of unsigned integers", a.componentType);
  }
  const auto read_as = [&](const auto& decode) {
    return read<LargeArray<std::uint32_t>>(accessor, kAll, {bytes, bytes, false}, decode, nullptr);
  };
  if (bytes == sizeof(std::uint32_t)) return read_as(load<std::uint32_t>);
  return read_as([bytes](const std::byte* p) { return load_index(p, bytes); });
}

}  // namespace meshgauge::api
