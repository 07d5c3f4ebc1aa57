#include "mesh_files.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <minizip/zip.h>
#include <zlib.h>

namespace meshgauge::bench {
namespace {

void save(const std::string& content, const Path& path) {
  std::ofstream file(path, std::ios::binary);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  if (!file.flush()) std::exit(1);
}

template <class... Values>
void append(std::string& out, const char* format, Values... values) {
  char line[512];
  out.append(line, static_cast<std::size_t>(std::snprintf(line, sizeof line, format, values...)));
}

template <class T>
void append_raw(std::string& out, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(bytes, sizeof value);
}

void append_floats(std::string& out, const Vec3& p) {
  for (int k = 0; k < 3; ++k) append_raw(out, static_cast<float>(p[k]));
}

// "X Y Z\n" a line, X beginning with `before`.
void append_positions(std::string& out, const char* before, const Mesh& mesh) {
  for (const Vec3& p : mesh.positions) append(out, "%s%.16g %.16g %.16g\n", before, p.x(), p.y(), p.z());
}

void append_triangles(std::string& out, const char* before, const Mesh& mesh, std::uint32_t first) {
  for (const Triangle& t : mesh.triangles) {
    append(out, "%s%u %u %u\n", before, t[0] + first, t[1] + first, t[2] + first);
  }
}

std::string base64(const std::string& data) {
  const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < data.size(); i += 3) {  // its size is a multiple of 12
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8U | static_cast<unsigned char>(data[i + k]);
    for (unsigned k = 0; k < 4; ++k) out += letters[bits >> (18 - 6 * k) & 63U];
  }
  return out;
}

std::string gltf_data(const Mesh& mesh) {
  std::string data;
  for (const Vec3& p : mesh.positions) append_floats(data, p);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t corner : t) append_raw(data, corner);
  }
  return data;
}

std::string gltf_json(const Mesh& mesh, const std::string& uri) {
  const std::size_t vertex_bytes = 12 * mesh.positions.size();
  const std::size_t index_bytes = 12 * mesh.triangles.size();
  const auto number = [](std::size_t n) { return std::to_string(n); };
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
         number(mesh.positions.size()) + R"(},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" +
         number(3 * mesh.triangles.size()) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + number(vertex_bytes) +
         R"(},{"buffer":0,"byteOffset":)" + number(vertex_bytes) + R"(,"byteLength":)" + number(index_bytes) +
         R"(}],"buffers":[{"byteLength":)" + number(vertex_bytes + index_bytes) + uri + "}]}";
}

std::string ply_header(const Mesh& mesh, const std::string& format) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(mesh.positions.size()) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
         std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

void add_to_zip(zipFile archive, const char* name, const std::string& content) {
  const bool ok = zipOpenNewFileInZip64(archive, name, nullptr, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                                        Z_DEFAULT_COMPRESSION, 0) == ZIP_OK &&
                  zipWriteInFileInZip(archive, content.data(), static_cast<unsigned>(content.size())) == ZIP_OK &&
                  zipCloseFileInZip(archive) == ZIP_OK;
  if (!ok) std::exit(1);
}

}  // namespace

Mesh grid(std::uint32_t side) {
  Mesh mesh;
  for (std::uint32_t i = 0; i <= side; ++i) {
    for (std::uint32_t j = 0; j <= side; ++j) {
      const double x = 0.1234567891 * i + 1.0 / 3;
      const double y = 0.1234567891 * j + 1.0 / 7;
      mesh.positions.emplace_back(x, y, std::sin(x) * std::cos(y));
    }
  }
  const auto index = [side](std::uint32_t i, std::uint32_t j) { return i * (side + 1) + j; };
  for (std::uint32_t i = 0; i < side; ++i) {
    for (std::uint32_t j = 0; j < side; ++j) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  return mesh;
}

void write_stl(const Mesh& mesh, const Path& path) {
  std::string out(80, '\0');
  append_raw(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& triangle : mesh.triangles) {
    out.append(12, '\0');
    for (const std::uint32_t corner : triangle) append_floats(out, mesh.positions[corner]);
    out.append(2, '\0');
  }
  save(out, path);
}

void write_ascii_stl(const Mesh& mesh, const Path& path) {
  std::string out = "solid grid\n";
  for (const Triangle& triangle : mesh.triangles) {
    out += "facet normal 0 0 1\n  outer loop\n";
    for (const std::uint32_t corner : triangle) {
      const Vec3& p = mesh.positions[corner];
      append(out, "    vertex %.16g %.16g %.16g\n", p.x(), p.y(), p.z());
    }
    out += "  endloop\nendfacet\n";
  }
  save(out + "endsolid grid\n", path);
}

void write_obj(const Mesh& mesh, const Path& path) {
  std::string out;
  append_positions(out, "v ", mesh);
  append_triangles(out, "f ", mesh, 1);
  save(out, path);
}

void write_ascii_ply(const Mesh& mesh, const Path& path) {
  std::string out = ply_header(mesh, "ascii");
  append_positions(out, "", mesh);
  append_triangles(out, "3 ", mesh, 0);
  save(out, path);
}

void write_binary_ply(const Mesh& mesh, const Path& path) {
  std::string out = ply_header(mesh, "binary_little_endian");
  for (const Vec3& p : mesh.positions) {
    for (int k = 0; k < 3; ++k) append_raw(out, p[k]);
  }
  for (const Triangle& triangle : mesh.triangles) {
    out += '\x03';
    for (const std::uint32_t corner : triangle) append_raw(out, corner);
  }
  save(out, path);
}

void write_off(const Mesh& mesh, const Path& path) {
  std::string out = "OFF\n";
  append(out, "%zu %zu 0\n", mesh.positions.size(), mesh.triangles.size());
  append_positions(out, "", mesh);
  append_triangles(out, "3 ", mesh, 0);
  save(out, path);
}

void write_glb(const Mesh& mesh, const Path& path) {
  const std::string data = gltf_data(mesh);
  std::string json = gltf_json(mesh, "");
  while (json.size() % 4 != 0) json += ' ';
  std::string out = "glTF";
  append_raw(out, std::uint32_t{2});
  append_raw(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + data.size()));
  append_raw(out, static_cast<std::uint32_t>(json.size()));
  out += "JSON" + json;
  append_raw(out, static_cast<std::uint32_t>(data.size()));
  save(out + std::string("BIN\0", 4) + data, path);
}

void write_gltf(const Mesh& mesh, const Path& path) {
  const std::string uri = R"(,"uri":"data:application/octet-stream;base64,)" + base64(gltf_data(mesh)) + '"';
  save(gltf_json(mesh, uri), path);
}

void write_3mf(const Mesh& mesh, const Path& path) {
  std::string model = R"(<?xml version="1.0"?>
<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" unit="millimeter"><resources>
<object id="1" type="model"><mesh><vertices>
)";
  for (const Vec3& p : mesh.positions)
    append(model, "<vertex x=\"%.16g\" y=\"%.16g\" z=\"%.16g\"/>\n", p.x(), p.y(), p.z());
  model += "</vertices><triangles>\n";
  for (const Triangle& t : mesh.triangles)
    append(model, "<triangle v1=\"%u\" v2=\"%u\" v3=\"%u\"/>\n", t[0], t[1], t[2]);
  model += "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>\n";
  zipFile archive = zipOpen64(path.c_str(), APPEND_STATUS_CREATE);
  if (archive == nullptr) std::exit(1);
  add_to_zip(
      archive, "_rels/.rels",
      R"(<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r")"
      R"( Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/>)"
      "</Relationships>");
  add_to_zip(archive, "3D/3dmodel.model", model);
  zipClose(archive, nullptr);
}

void write_gzip(const Path& from, const Path& path) {
  std::ifstream file(from, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  gzFile out = gzopen(path.c_str(), "wb");
  const bool ok = gzwrite(out, content.data(), static_cast<unsigned>(content.size())) != 0;
  if (gzclose(out) != Z_OK || !ok) std::exit(1);
}

}  // namespace meshgauge::bench
