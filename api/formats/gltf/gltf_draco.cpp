#include "api/formats/gltf/gltf_draco.h"

#include <optional>
#include <utility>

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

namespace meshgauge::api {
namespace {

// The sizes that a stream claims before its connectivity.
struct Claim {
  std::uint32_t faces = 0;
  std::uint32_t points = 0;
  std::uint8_t attribute_tables = 0;  // seams of attributes; each takes memory for every corner
};

bool take_count(draco::DecoderBuffer& in, bool is_varint, std::uint32_t& out) {
  return is_varint ? draco::DecodeVarint(&out, &in) : in.Decode(&out);
}

// Both functions read a copy of the decoder's buffer, positioned where the connectivity begins. Older streams have
// 32-bit numbers, which libdraco also reads.
bool take_claim(const draco::MeshEdgebreakerDecoder& /*kind*/, draco::DecoderBuffer in, Claim& out) {
  const bool is_varint = in.bitstream_version() >= DRACO_BITSTREAM_VERSION(2, 0);
  std::uint32_t ignored = 0;
  if (in.bitstream_version() < DRACO_BITSTREAM_VERSION(2, 2) && !take_count(in, is_varint, ignored)) return false;
  return take_count(in, is_varint, out.points) && take_count(in, is_varint, out.faces) &&
         in.Decode(&out.attribute_tables);
}

bool take_claim(const draco::MeshSequentialDecoder& /*kind*/, draco::DecoderBuffer in, Claim& out) {
  const bool is_varint = in.bitstream_version() >= DRACO_BITSTREAM_VERSION(2, 2);
  return take_count(in, is_varint, out.faces) && take_count(in, is_varint, out.points);
}

// A decoder that checks the claimed sizes first. libdraco trusts them: a stream of twenty bytes that claims 2^31 / 3
// faces takes 35 GB.
template <class Decoder>
class Checked : public Decoder {
 public:
  Checked(const Source& source, GltfBudget& budget) : source_(source), budget_(budget) {}

  std::optional<Error> refusal;

 protected:
  // NOLINTBEGIN(readability-identifier-naming): libdraco's names
  bool DecodeConnectivity() override {
    Claim claim;
    if (!take_claim(*this, *this->buffer(), claim)) return false;
    if (claim.faces > source_.limits.max_triangles) {
      return refuse(too_many(source_, "triangles", source_.limits.max_triangles));
    }
    if (claim.points > vertex_limit(source_)) return refuse(too_many(source_, "vertices", vertex_limit(source_)));
    return take(std::size_t{12} * claim.faces * (1 + claim.attribute_tables)) && Decoder::DecodeConnectivity();
  }

  // Called when the headers of all attributes have been read, but none of their values.
  bool DecodeAllAttributes() override {
    const draco::PointCloud& points = *this->point_cloud();
    if (points.num_points() > vertex_limit(source_)) {
      return refuse(too_many(source_, "vertices", vertex_limit(source_)));
    }
    std::size_t bytes = 0;
    for (std::int32_t i = 0; i < points.num_attributes(); ++i) {
      bytes += static_cast<std::size_t>(points.attribute(i)->byte_stride());
    }
    return take(bytes * points.num_points()) && Decoder::DecodeAllAttributes();
  }
  // NOLINTEND(readability-identifier-naming)

 private:
  bool refuse(Error error) {
    refusal = std::move(error);
    return false;
  }
  bool take(std::size_t bytes) {
    auto ok = budget_.take(bytes);
    return ok || refuse(std::move(ok).error());
  }

  const Source& source_;
  GltfBudget& budget_;
};

template <class Decoder>
Result<Done> decode(const Source& source, const std::string& where, std::span<const std::byte> stream,
                    GltfBudget& budget, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  const draco::DecoderOptions options;
  Checked<Decoder> decoder(source, budget);
  const draco::Status status = decoder.Decode(options, &buffer, &mesh);
  if (decoder.refusal) return std::move(*decoder.refusal);
  if (status.ok()) return Done{};
  return at(source, where, ErrorCode::unreadable_mesh,
            "libdraco cannot decode it: " + printable(status.error_msg_string(), 100));
}

Result<Done> decode_any(const Source& source, const std::string& where, std::span<const std::byte> stream,
                        GltfBudget& budget, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::DracoHeader header;
  const auto fail = [&](const char* what) { return at(source, where, ErrorCode::unreadable_mesh, what); };
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return fail("not a Draco stream");
  if (header.encoder_type != draco::TRIANGULAR_MESH) return fail("a Draco stream of points, not of triangles");
  if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING) {
    return decode<draco::MeshEdgebreakerDecoder>(source, where, stream, budget, mesh);
  }
  if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING) {
    return decode<draco::MeshSequentialDecoder>(source, where, stream, budget, mesh);
  }
  return fail("a Draco stream of an unknown encoding");
}

// Returns the component type for an accessor; 0: accessors have no such type.
int component_type(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return TINYGLTF_COMPONENT_TYPE_BYTE;
    case draco::DT_UINT8:
      return TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    case draco::DT_INT16:
      return TINYGLTF_COMPONENT_TYPE_SHORT;
    case draco::DT_UINT16:
      return TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    case draco::DT_FLOAT32:
      return TINYGLTF_COMPONENT_TYPE_FLOAT;
    default:
      return 0;
  }
}

// Returns the values of all points; nullopt: some point has none, which happens in broken streams.
std::optional<GltfColumn> column_of(const draco::PointAttribute& attribute, std::size_t points) {
  GltfColumn out;
  out.component_type = component_type(attribute.data_type());
  out.components = static_cast<std::size_t>(attribute.num_components());
  out.count = points;
  const std::size_t stride = out.components * static_cast<std::size_t>(draco::DataTypeLength(attribute.data_type()));
  const draco::DataBuffer* values = attribute.buffer();
  if (values == nullptr) return std::nullopt;
  if (!attribute.is_mapping_identity() && attribute.indices_map_size() < points) return std::nullopt;
  out.bytes.reserve(points * stride);
  for (std::uint32_t i = 0; i < points; ++i) {
    const std::uint32_t value = attribute.mapped_index(draco::PointIndex(i)).value();
    const std::int64_t first = attribute.GetBytePos(draco::AttributeValueIndex(value));
    if (value >= attribute.size() || first < 0 || static_cast<std::size_t>(first) + stride > values->data_size()) {
      return std::nullopt;
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(values->data() + first);
    out.bytes.insert(out.bytes.end(), bytes, bytes + stride);
  }
  return out;
}

}  // namespace

Result<GltfDracoMesh> decode_draco(const Source& source, const std::string& where, std::span<const std::byte> stream,
                                   const std::map<std::string, std::uint32_t>& ids, GltfBudget& budget) {
  const auto fail = [&](const std::string& what) { return at(source, where, ErrorCode::unreadable_mesh, what); };
  if (auto ok = budget.take(stream.size()); !ok) return std::move(ok).error();
  draco::Mesh mesh;
  if (auto ok = decode_any(source, where, stream, budget, mesh); !ok) return std::move(ok).error();
  GltfDracoMesh out;
  out.points = mesh.num_points();
  out.corners.reserve(std::size_t{3} * mesh.num_faces());
  for (std::uint32_t i = 0; i < mesh.num_faces(); ++i) {
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(i))) {
      if (corner.value() >= out.points) return fail("a triangle of the Draco stream names a point that does not exist");
      out.corners.push_back(corner.value());
    }
  }
  for (const auto& [name, id] : ids) {
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
    if (attribute == nullptr)
      return fail(name + " is attribute " + std::to_string(id) + ", which Draco's stream lacks");
    auto column = column_of(*attribute, out.points);
    if (!column) return fail("the Draco stream has points without a value of " + name);
    out.columns.emplace(name, *std::move(column));
  }
  return out;
}

}  // namespace meshgauge::api
