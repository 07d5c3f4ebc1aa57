#include "tests/api/formats/gltf_compressed.h"

#include <stdexcept>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include "tests/api/formats/gltf_documents.h"

namespace meshgauge::api::test {

std::string draco_stream(const std::vector<float>& positions, const std::vector<std::uint32_t>& corners, int bits,
                         int speed) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(corners.size() / 3));
  const int attribute = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (std::size_t t = 0; t < corners.size() / 3; ++t) {
    builder.SetAttributeValuesForFace(
        attribute, draco::FaceIndex(static_cast<std::uint32_t>(t)), &positions[std::size_t{3} * corners[3 * t]],
        &positions[std::size_t{3} * corners[3 * t + 1]], &positions[std::size_t{3} * corners[3 * t + 2]]);
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetSpeedOptions(speed, speed);
  if (bits > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer out;
  if (mesh == nullptr || !encoder.EncodeMeshToBuffer(*mesh, &out).ok())
    throw std::runtime_error("libdraco cannot encode");
  return {out.data(), out.size()};
}

std::string draco_glb(const std::string& stream) {
  json document = tetrahedron();
  document["extensionsUsed"] = document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  document["bufferViews"] = {{{"buffer", 0}, {"byteLength", stream.size()}}};
  document["buffers"][0]["byteLength"] = stream.size();
  for (json& accessor : document["accessors"]) accessor.erase("bufferView");
  document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  return glb(document, stream);
}

std::string meshopt_glb(const std::string& extension) {
  const std::string data = tetrahedron_data();
  std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(4, 12));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), data.data(), 4, 12));
  const std::size_t vertices = stream.size();
  std::vector<unsigned> indices(kIndices.begin(), kIndices.end());
  stream.resize(vertices + meshopt_encodeIndexBufferBound(indices.size(), 4));
  const std::size_t length = meshopt_encodeIndexBuffer(&stream[vertices], stream.size() - vertices, indices.data(), 12);
  stream.resize(vertices + length);

  json document = tetrahedron();
  document["extensionsUsed"] = document["extensionsRequired"] = {extension};
  document["buffers"] = {{{"byteLength", stream.size()}},
                         {{"byteLength", 72}, {"extensions", {{extension, {{"fallback", true}}}}}}};
  for (json& view : document["bufferViews"]) view["buffer"] = 1;
  document["bufferViews"][0]["extensions"][extension] = {
      {"buffer", 0}, {"byteLength", vertices}, {"byteStride", 12}, {"count", 4}, {"mode", "ATTRIBUTES"}};
  document["bufferViews"][1]["extensions"][extension] = {
      {"buffer", 0}, {"byteOffset", vertices}, {"byteLength", length}, {"byteStride", 2},
      {"count", 12}, {"mode", "TRIANGLES"},    {"filter", "NONE"}};
  return glb(document, std::string(stream.begin(), stream.end()));
}

}  // namespace meshgauge::api::test
