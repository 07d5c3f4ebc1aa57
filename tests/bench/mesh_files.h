// Writes a mesh as a file of each format, for readers_bench.
#pragma once

#include <filesystem>

#include "engine/mesh.h"

namespace meshgauge::bench {

// A height field of side x side squares, two triangles each. Coordinates of 16 digits, as exporters write doubles.
Mesh grid(std::uint32_t side);

using Path = std::filesystem::path;

void write_stl(const Mesh& mesh, const Path& path);
void write_ascii_stl(const Mesh& mesh, const Path& path);
void write_obj(const Mesh& mesh, const Path& path);
void write_ascii_ply(const Mesh& mesh, const Path& path);
void write_binary_ply(const Mesh& mesh, const Path& path);  // little endian, doubles
void write_off(const Mesh& mesh, const Path& path);
void write_glb(const Mesh& mesh, const Path& path);
void write_gltf(const Mesh& mesh, const Path& path);  // the buffer as a data URI
void write_3mf(const Mesh& mesh, const Path& path);
void write_gzip(const Path& from, const Path& path);

}  // namespace meshgauge::bench
