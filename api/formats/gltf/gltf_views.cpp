#include "api/formats/gltf/gltf_views.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "api/formats/gltf/meshopt.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kMostPerByte = 256;  // a block of 256 elements takes at least one byte

// Returns the defect in the numbers of a meshopt view of `length` bytes; nullopt: none.
std::optional<std::string> defect(const GltfMeshopt& meshopt, std::size_t length) {
  const bool is_attributes = meshopt.mode == "ATTRIBUTES";
  const bool is_triangles = meshopt.mode == "TRIANGLES";
  if (!is_attributes && !is_triangles && meshopt.mode != "INDICES") {
    return "the mode " + in_quotes(meshopt.mode) + " is unknown; known are ATTRIBUTES, TRIANGLES and INDICES";
  }
  const bool good_stride = is_attributes ? meshopt.stride >= 4 && meshopt.stride <= 256 && meshopt.stride % 4 == 0
                                         : meshopt.stride == 2 || meshopt.stride == 4;
  if (!good_stride) {
    return "a byteStride of " + std::to_string(meshopt.stride) +
           (is_attributes ? ", not a multiple of 4 from 4 to 256" : ", neither 2 nor 4");
  }
  if (is_triangles && meshopt.count % 3 != 0) {
    return std::to_string(meshopt.count) + " indices are not a multiple of three";
  }
  if (meshopt.filter != "NONE" && !is_attributes) {
    return "the filter " + in_quotes(meshopt.filter) + " in the mode " + meshopt.mode +
           "; only ATTRIBUTES may have one";
  }
  if (meshopt.filter == "QUATERNION" && meshopt.stride != 8) {
    return "the filter QUATERNION with a byteStride of " + std::to_string(meshopt.stride) + "; it needs 8";
  }
  if (meshopt.count / kMostPerByte > meshopt.length) {
    return std::to_string(meshopt.count) + " elements do not fit in " + std::to_string(meshopt.length) + " bytes";
  }
  if (meshopt.count * meshopt.stride != length) {
    return "count x byteStride is " + std::to_string(meshopt.count * meshopt.stride) + ", but the bufferView has " +
           std::to_string(length) + " bytes";
  }
  return std::nullopt;
}

bool decode(const GltfMeshopt& meshopt, std::span<const std::byte> stream, std::span<std::byte> out) {
  if (meshopt.mode == "TRIANGLES") return decode_meshopt_triangles(stream, meshopt.stride, out);
  if (meshopt.mode == "INDICES") return decode_meshopt_indices(stream, meshopt.stride, out);
  return decode_meshopt_attributes(stream, meshopt.stride, out);
}

}  // namespace

GltfBudget::GltfBudget(const Source& sent)
    : sent_(sent),
      most_bytes_(expansion_limit(sent.bytes.size(), sent.limits)),
      most_steps_(kFreeSteps + kStepsPerByte * sent.bytes.size()) {}

Result<Done> GltfBudget::take(std::size_t bytes) {
  if (bytes > most_bytes_ - bytes_) {
    return expands_too_far(sent_.part, most_bytes_, sent_.bytes.size(), "compressed glTF");
  }
  bytes_ += bytes;
  return Done{};
}

Result<Done> GltfBudget::work(std::size_t steps, const std::string& where) {
  if (steps > most_steps_ - steps_) {
    return at(
        sent_, where, ErrorCode::too_large,
        "takes too long: nodes, instances, primitives and morph targets read the same numbers more often than the "
        "limit for a file of " +
            std::to_string(sent_.bytes.size()) +
            " bytes; remove objects without triangles, or save the model without instances");
  }
  steps_ += steps;
  return Done{};
}

void GltfBudget::refund(std::size_t since, std::size_t triangles) {
  steps_ -= std::min(steps_ - since, kStepsPerTriangle * triangles);
}

// No sum overflows 64 bits: all numbers come from check_gltf() and are below 2^53.
Result<std::span<const std::byte>> GltfViews::piece(const std::string& where, const std::string& what,
                                                    std::size_t buffer, std::size_t offset, std::size_t length) const {
  const auto fail = [&](const std::string& why) { return at(source_, where, ErrorCode::unreadable_mesh, what + why); };
  if (buffer >= buffers_.size()) return fail(" names buffer " + std::to_string(buffer) + ", which does not exist");
  if (offset + length > buffers_[buffer].size()) {
    return fail(" reaches beyond its buffer of " + std::to_string(buffers_[buffer].size()) + " bytes");
  }
  return buffers_[buffer].subspan(offset, length);
}

Result<std::span<const std::byte>> GltfViews::bytes(std::size_t view, const std::string& where) {
  const std::string name = "bufferViews[" + std::to_string(view) + "]";
  if (view >= model_.bufferViews.size()) {
    return at(source_, where, ErrorCode::unreadable_mesh, name + " does not exist");
  }
  const auto meshopt = document_.meshopt.find(view);
  if (meshopt == document_.meshopt.end()) {
    const tinygltf::BufferView& v = model_.bufferViews[view];
    return piece(where, name, static_cast<std::size_t>(v.buffer), v.byteOffset, v.byteLength);
  }
  auto known = decompressed_.find(view);
  if (known == decompressed_.end()) {
    auto decompressed = decompress(view, meshopt->second);
    if (!decompressed) return std::move(decompressed).error();
    known = decompressed_.emplace(view, *std::move(decompressed)).first;
  }
  return std::span<const std::byte>(known->second);
}

Result<std::vector<std::byte>> GltfViews::decompress(std::size_t view, const GltfMeshopt& meshopt) {
  const std::string where = "bufferViews[" + std::to_string(view) + "]";
  const auto fail = [&](const std::string& what, ErrorCode code = ErrorCode::unreadable_mesh) {
    return at(source_, where, code, "meshopt: " + what);
  };
  const auto stream = piece(where, "meshopt:", meshopt.buffer, meshopt.offset, meshopt.length);
  if (!stream) return stream.error();
  if (const auto wrong = defect(meshopt, model_.bufferViews[view].byteLength)) return fail(*wrong);
  const bool exponential = meshopt.filter == "EXPONENTIAL";
  const bool quaternion = meshopt.filter == "QUATERNION";
  if (!exponential && !quaternion && meshopt.filter != "NONE") {
    return fail("positions, indices or transforms with the filter " + in_quotes(meshopt.filter) +
                    ", which is for normals and colours; save the model without it",
                ErrorCode::unsupported_format);
  }
  if (auto ok = budget_.take(meshopt.count * meshopt.stride + meshopt.length); !ok) return std::move(ok).error();
  std::vector<std::byte> out(meshopt.count * meshopt.stride);
  if (!decode(meshopt, *stream, out)) {
    return fail("not a stream of " + std::to_string(meshopt.count) + " elements of " + std::to_string(meshopt.stride) +
                " bytes in the mode " + meshopt.mode);
  }
  if (exponential) undo_meshopt_exponential(out);
  if (quaternion) undo_meshopt_quaternion(out);
  return out;
}

}  // namespace meshgauge::api
