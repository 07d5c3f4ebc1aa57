#include "tests/api/formats/small_files.h"

#include <algorithm>
#include <cstdint>
#include <sstream>

#include "tests/api/formats/files.h"
#include "tests/api/formats/gltf_documents.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

// --- text -----------------------------------------------------------------------------------------------------------

// Every index is below 10: a number cut to its first digits would go unnoticed.
const std::string kObj =
    "# part\nv 0 0 0 1\nv 1.5e-3 +2 .5\nv -1 2. 3\nv 0 0 1\nvn 0 0 1\ng a b\nf 1//1 2/3/4 -2\nf 1 2 3 4\nl 1 2\n"
    "v 0 1 0.25\nf 5 3 2\n";
const std::string kContinuedObj =
    "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 0 0 1\r\no x\\\r\ny\r\nf 1 2 \\\r\n3\r\nf 1 2 3 \\\r\n4\r\nf 4 3 2\r\n";
// Beside faces, what is noted: surfaces that are not read, a word of no specification, bytes behind the last line.
const std::string kNotedObj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\ncstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nparm u 0 1\nend\n"
    "bzp 1 2 3 4\ncurv 0 1 1 2\ncall x.obj\nface 1 2 4\nf 4 3 2\n" +
    std::string("\0\x1A\n", 3);
const std::string kAsciiStl =
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e0 0 0\nvertex 0 1 -0\nendloop\nendfacet\n"
    "endsolid x\n";
const std::string kVertexLines = "0 0 0\n1 0 0\n0 1e-1 0\n0 0 1.5\n";
const std::string kAllOff =
    "STCNOFF\n3 1 3\n0 0 0 0 0 1 9 9 9 .5 .5\n1 0 0 0 0 1 9 9 9 1 1\n0 1 0 0 0 1 9 9 9 0 0\n3 0 1 2\n";
const std::string kFaceLines = "3 0 1 2\n4 0 1 2 3\n3 1 2 3\n";

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

// Counts by the words of each line: "f" with three corners or more.
std::size_t triangles_of_obj(std::string_view left) {
  std::string joined(left);
  for (const std::string_view continued : {"\\\r\n", "\\\n", "\\\r"}) {
    for (std::size_t at = 0; (at = joined.find(continued, at)) != std::string::npos;) {
      joined.replace(at, continued.size(), " ");
    }
  }
  std::size_t triangles = 0;
  std::istringstream lines(joined);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word != "f") continue;
    std::size_t corners = 0;
    while (words >> word) ++corners;
    triangles += corners < 3 ? 0 : corners - 2;
  }
  return triangles;
}

std::size_t triangles_of_stl(std::string_view left) {
  std::size_t triangles = 0;
  const std::string text = lower(std::string(left));
  for (std::size_t at = 0; (at = text.find("endfacet", at)) != std::string::npos; ++at) ++triangles;
  return triangles;
}

// --- bytes ----------------------------------------------------------------------------------------------------------

template <class T>
std::string in_order(T value, bool big_endian) {
  std::string out = raw(value);
  if (big_endian) std::ranges::reverse(out);
  return out;
}

std::string binary_stl(std::string header) {
  header.resize(80, '\0');
  std::string out = header + raw(std::uint32_t{2});
  for (int facet = 0; facet < 2; ++facet) {
    for (int k = 0; k < 12; ++k) out += raw(static_cast<float>(k * k - 2 * facet) * 0.25F);
    out += "\xAB\xCD";  // as colours use them
  }
  return out;
}

std::string ply(const std::string& encoding, const std::string& body) {
  return "ply\nformat " + encoding +
         " 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 3\nproperty list uchar int vertex_indices\nend_header\n" +
         body;
}

std::string binary_ply(bool big_endian) {
  std::string body;
  for (const float c : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 0.1F, 0.F, 0.F, 0.F, 1.5F}) body += in_order(c, big_endian);
  const std::vector<std::vector<std::int32_t>> faces = {{0, 1, 2}, {0, 1, 2, 3}, {1, 2, 3}};
  for (const auto& face : faces) {
    body += static_cast<char>(face.size());
    for (const std::int32_t index : face) body += in_order(index, big_endian);
  }
  return ply(big_endian ? "binary_big_endian" : "binary_little_endian", body);
}

// With the number of colour components if the byte order is Geomview's.
std::string binary_off(bool big_endian) {
  std::string out = "OFF BINARY\n";
  for (const std::uint32_t count : {4U, 3U, 0U}) out += in_order(count, big_endian);
  for (const float c : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 0.1F, 0.F, 0.F, 0.F, 1.5F}) out += in_order(c, big_endian);
  const std::vector<std::vector<std::uint32_t>> faces = {{0, 1, 2}, {0, 1, 2, 3}, {1, 2, 3}};
  for (const auto& face : faces) {
    out += in_order(static_cast<std::uint32_t>(face.size()), big_endian);
    for (const std::uint32_t index : face) out += in_order(index, big_endian);
    if (big_endian) out += in_order(std::uint32_t{1}, big_endian) + in_order(0.5F, big_endian);
  }
  return out;
}

// A strip of two triangles, then one of one.
std::string strips_ply() {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
         kVertexLines + "8 0 1 2 3 -1 2 1 0\n";
}

// With a byte order mark, edges, lists of faces beside their corners, and padding.
std::string padded_ply() {
  return "\xEF\xBB\xBFply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element edge 1\nproperty int vertex1\nproperty int vertex2\n"
         "element face 3\nproperty list uchar int vertex_indices\nproperty list uchar int holes\nend_header\n" +
         kVertexLines + "0 1\n3 0 1 2 0\n4 0 1 2 3 0\n3 1 2 3 0\n" + std::string("\x1A\0", 2);
}

// Other elements and properties around those that are read, and coordinates of two types.
std::string mixed_ply() {
  std::string out =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n"
      "element other 1\nproperty list uchar short s\nelement face 2\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  for (int i = 0; i < 3; ++i) out += raw(static_cast<float>(i)) + raw(static_cast<float>(i * i)) + raw(0.5 * i);
  out += "\x02" + std::string(4, 's');
  for (int face = 0; face < 2; ++face) {
    out += '\x03';
    for (const std::int32_t i : {0, 1, 2}) out += raw(i);
  }
  return out;
}

// --- glTF -----------------------------------------------------------------------------------------------------------

std::string tetrahedron_json(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":)"
         R"([{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":72)" +
         uri +
         R"(}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})";
}

std::string embedded_gltf() {
  return tetrahedron_json(R"(,"uri":"data:application/octet-stream;base64,)" + base64(tetrahedron_data()) + '"');
}

std::string external_gltf() { return tetrahedron_json(R"(,"uri":"./x.bin")"); }

std::string glb(std::string json, std::string data) {
  while (json.size() % 4 != 0) json += ' ';
  while (data.size() % 4 != 0) data += '\0';
  const std::string chunks = raw(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                             raw(static_cast<std::uint32_t>(data.size())) + std::string("BIN\0", 4) + data;
  return "glTF" + raw(std::uint32_t{2}) + raw(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

// Nested nodes, a transform, a sparse accessor.
std::string sparse_glb() {
  std::string data;
  for (int k = 0; k < 9; ++k) data += raw(static_cast<float>(k * k));
  for (const int i : {0, 1, 2, 0}) data += raw(static_cast<std::uint16_t>(i));
  return glb(
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"scale":[2,2,2]},{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":44}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":)"
      R"({"bufferView":1,"componentType":5123},"values":{"bufferView":0}}},)"
      R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})",
      data);
}

// A strip of five corners of 8 bits over interleaved vertices of 16 bits, normalised.
std::string strip_glb() {
  std::string data;
  for (const int c : {0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0, 9, 9, 1, 0, 0, 5, 5, 0})
    data += raw(static_cast<std::uint16_t>(c));
  for (const int i : {0, 1, 2, 3, 4}) data += raw(static_cast<std::uint8_t>(i));
  return glb(
      R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"scenes":[{"nodes":[0]}],)"
      R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":5}]}],)"
      R"("buffers":[{"byteLength":45}],"bufferViews":[{"buffer":0,"byteLength":40,"byteStride":8},)"
      R"({"buffer":0,"byteOffset":40,"byteLength":5}],"accessors":[{"bufferView":0,"componentType":5123,"count":5,)"
      R"("normalized":true,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":5,"type":"SCALAR"}]})",
      data);
}

// Vertices of 16 bits, 6 bytes apart, a corner more than two triangles need, and bytes after the end.
std::string odd_glb() {
  std::string data;
  for (const int c : {0, 0, 0, 9, 0, 0, 0, 9, 0, 9, 9, 1}) data += raw(static_cast<std::uint16_t>(c));
  for (const int i : {0, 1, 2, 1, 3, 2, 0}) data += raw(static_cast<std::uint8_t>(i));
  return glb(R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"scenes":[{"nodes":[0]}],)"
             R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
             R"("buffers":[{"byteLength":31}],"bufferViews":[{"buffer":0,"byteLength":24,"byteStride":6},)"
             R"({"buffer":0,"byteOffset":24,"byteLength":7,"byteStride":0}],"accessors":[{"bufferView":0,)"
             R"("componentType":5123,"count":4,"type":"VEC3"},)"
             R"({"bufferView":1,"componentType":5121,"count":7,"type":"SCALAR"}]})",
             data) +
         "tail";
}

// What is not read: voxels, an unknown extension, levels of detail, a material that displaces, an animation.
std::string extensions_glb() {
  const std::string animations = R"("animations":[{}],"materials":[{"extensions":{"KHR_materials_displacement":{}}}],)";
  std::string json = tetrahedron_json("");
  json.insert(1, animations);
  const std::string primitive = R"("indices":1})";
  json.insert(json.find(primitive) + primitive.size(),
              R"(,{"attributes":{},"mode":7,"extensions":{"EXT_primitive_voxels":{}}})");
  const std::string node = R"({"mesh":0)";
  json.insert(json.find(node) + node.size(), R"(,"extensions":{"ABC_shape":{},"MSFT_lod":{"ids":[1]}})");
  return glb(json, tetrahedron_data());
}

}  // namespace

std::string small_model() {
  return model(triangle_object(1) +
                   "<object id=\"2\"><components><component objectid=\"1\" "
                   "transform=\"1 0 0 0 1 0 0 0 1 0 0 1\"/></components></object>",
               "<item objectid=\"2\"/><item objectid=\"1\"/>", "unit=\"inch\"");
}

std::string small_scene_and_data() { return external_gltf() + '\0' + tetrahedron_data(); }

// A triangle, and an object that does not belong to the part.
std::string zip64_package() {
  std::string support = triangle_object(2);
  support.replace(support.find("\"model\""), 7, "\"support\"");
  const std::string both = model(triangle_object(1) + support, "<item objectid=\"1\"/><item objectid=\"2\"/>");
  std::vector<ZipEntry> entries{{"_rels/.rels", relationships()}, {"3D/3dmodel.model", both}};
  for (ZipEntry& entry : entries) entry.in_zip64 = true;
  return zip64(entries, entries.size());
}

std::string small_foreign_model() {
  std::string object = triangle_object(1);
  object.insert(object.find("</triangles>"), "<x:curved v1=\"0\"/>");
  object.insert(object.find("type="), "s:slicestackid=\"5\" ");
  return model("<ms:look id=\"4\"/>" + object, "<item objectid=\"1\"/>",
               "xmlns:x=\"u\" xmlns:s=\"http://schemas.microsoft.com/3dmanufacturing/slice/2015/07\"");
}

// As some programs for Windows write it: backslashes in names, a relative target; and a prefix that is not declared.
std::string backslash_package() {
  return zip({{"_rels\\.rels", relationships("./3D/3dmodel.model")}, {"3D\\3dmodel.model", small_foreign_model()}});
}

std::vector<SmallFile> small_files() {
  const std::string two_solids = kAsciiStl + "SOLID Y" + kAsciiStl.substr(7);
  return {
      {"plain.obj", kObj, 5, 4, 1, 2, triangles_of_obj},
      {"continued.obj", kContinuedObj, 4, 4, 2, 2, triangles_of_obj},
      {"noted.obj", kNotedObj, 4, 2, 3, 2, triangles_of_obj},
      {"binary.stl", binary_stl("made by a test"), 6, 2},
      {"solid.stl", binary_stl("solid x"), 6, 2},
      {"ascii.stl", kAsciiStl, 3, 1, 3, 0, triangles_of_stl},
      {"solids.stl", two_solids, 6, 2, 3, 0, triangles_of_stl},
      {"joined.stl", "\xEF\xBB\xBF" + kAsciiStl.substr(0, kAsciiStl.size() - 3) + "x\n" + std::string(4, '\0'), 3, 1, 6,
       0, triangles_of_stl},
      {"ascii.ply", ply("ascii", kVertexLines + kFaceLines), 4, 4, 1, 2},
      {"little.ply", binary_ply(false), 4, 4},
      {"big.ply", binary_ply(true), 4, 4},
      {"mixed.ply", mixed_ply(), 3, 2},
      {"lines.ply", "ply\nmade by a test\n" + ply("ascii", kVertexLines + kFaceLines).substr(4), 4, 4, 1, 2},
      {"padded.ply", padded_ply(), 4, 4, 3, 2},
      {"strips.ply", strips_ply(), 4, 3, 1, 3},
      {"plain.off", "OFF # kind\n4 3 0\n" + kVertexLines + kFaceLines, 4, 4, 1, 2},
      {"colour.off", "COFF\n3 1 3\n0 0 0 9 0 0 1\n1 0 0 0 9 0 1\n0 1 0 0 0 9 1\n3 0 1 2 0.5 0.5 0.5\n", 3, 1, 13},
      {"all.off", kAllOff, 3, 1, 1},
      {"lines.off", "# c\n OFF4 2 0\n" + kVertexLines + "4\n0 1\n2 3\n\n3 0\n1 2\n", 4, 3, 1, 1},
      {"bare.off", "4 3\n" + kVertexLines + kFaceLines, 4, 4, 1, 2},
      {"padded.off", "OFF\n4 3 0\n" + kVertexLines + kFaceLines + std::string("\0\x1A", 2), 4, 4, 3, 2},
      {"big.off", binary_off(true), 4, 4, 0, 2},
      {"little.off", binary_off(false), 4, 4, 0, 2},
      {"embedded.gltf", embedded_gltf(), 4, 4},
      {"external.gltf", zip({{"m/s.gltf", external_gltf()}, {"m/x.bin", tetrahedron_data()}}), 4, 4},
      {"plain.glb", glb(tetrahedron_json(""), tetrahedron_data()), 4, 4},
      {"sparse.glb", sparse_glb(), 3, 1},
      {"strip.glb", strip_glb(), 5, 3, 0, 3},  // without a corner a shorter strip, with a repeated one a join
      {"odd.glb", odd_glb(), 4, 2, 4, 2},
      {"extensions.glb", extensions_glb(), 4, 4, 0, 2},
      {"normals.xyz", "# scan\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1e-1 0 0 0 1\n0 0 1.5 0 0 1\n", 4, 4, 0, 1},
      {"heading.xyz", "//X Y Z R\r\n4\r\n0 0 0 9\r\n1 0 0 9\r\n0 1e-1 0 9\r\n0 0 1.5 9\r\n\x1A", 4, 4, 0, 1},
      {"instances.3mf", package(small_model()), 6, 2},
      {"zip64.3mf", zip64_package(), 3, 1, 22},  // the end record of a plain archive, which Zip64 does not need
      {"backslash.3mf", backslash_package(), 3, 1},
      {"plain.obj.gz", gzipped(kObj), 5, 4},
      {"binary.stl.gz", gzipped(binary_stl("made by a test")), 6, 2},
  };
}

std::vector<std::pair<std::string, std::string>> small_archives() {
  std::vector<ZipEntry> entries{{"a", "some text, some text"}, {"b", "stored", 0}};
  std::vector<std::pair<std::string, std::string>> archives{{"plain", zip(entries, "a comment")}};
  for (ZipEntry& entry : entries) entry.in_zip64 = true;
  archives.emplace_back("fields", zip(entries));
  archives.emplace_back("zip64", zip64(entries, entries.size()));
  return archives;
}

std::string format_of(const SmallFile& file) {
  const std::string name = file.name.ends_with(".gz") ? file.name.substr(0, file.name.size() - 3) : file.name;
  return name.substr(name.rfind('.') + 1);
}

}  // namespace meshgauge::api::test
