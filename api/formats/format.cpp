#include "api/formats/format.h"

#include <new>
#include <utility>

#include "api/formats/detect.h"
#include "api/formats/file/gzip.h"
#include "api/formats/file/readers.h"
#include "api/formats/file/source.h"

namespace meshgauge::api {
namespace {

Result<ReadMesh> read_as(Format format, const Source& source) {
  switch (format) {
    case Format::obj:
      return read_obj(source);
    case Format::stl:
      return read_stl(source);
    case Format::ply:
      return read_ply(source);
    case Format::off:
      return read_off(source);
    case Format::three_mf:
      return read_3mf(source);
    case Format::xyz:
      return read_xyz(source);
    case Format::gltf:
    case Format::glb:
    case Format::arrays:  // never detected
      break;
  }
  return read_gltf(source, format);
}

// Nothing that is part of the surface is passed over in silence.
Result<Done> note_unread(const ReadHints& hints, ReadMesh& read) {
  if (read.unread.empty()) return Done{};
  if (read.mesh.triangles.empty()) return about(hints.part, ErrorCode::unsupported_format, read.unread.refusal());
  // In front: the remarks of a hostile file could fill the list.
  const std::vector<std::string> remarks = read.unread.remarks();
  read.notes.remarks.insert(read.notes.remarks.begin(), remarks.begin(), remarks.end());
  return Done{};
}

void note_contradictions(const ReadHints& hints, ReadMesh& read) {
  const auto other = [&](std::optional<Format> said) { return said == read.format ? std::nullopt : said; };
  read.notes.filename_says = other(format_by_name(hints.filename));
  read.notes.media_type_says = other(format_by_media_type(hints.media_type));
}

Result<ReadMesh> read_expanded(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits,
                               Corners corners) {
  if (auto error = refuse_foreign(bytes, hints)) return std::move(*error);
  const auto format = detect_format(bytes, hints);
  if (!format) {
    return about(hints.part, ErrorCode::unsupported_format,
                 "has an unknown format; supported are OBJ, STL, PLY, OFF, glTF, GLB, 3MF and XYZ");
  }
  auto read = read_as(*format, Source{bytes, hints.part, limits, corners});
  if (!read) return read;
  if (auto ok = note_unread(hints, *read); !ok) return std::move(ok).error();
  note_contradictions(hints, *read);
  const MeshLimits mesh_limits{limits.max_vertices, limits.max_triangles};
  if (auto ok = validate(read->mesh, mesh_limits, hints.part); !ok) return std::move(ok).error();
  return read;
}

Result<ReadMesh> read_gzip(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits,
                           Corners corners) {
  const auto expanded = expand_gzip(bytes, hints.part, limits, [&](std::span<const std::byte> beginning) {
    return refuse_foreign(beginning, hints);
  });
  if (!expanded) return expanded.error();
  // A 3MF in gzip expands twice; its limit counts from the size sent.
  ReadLimits what_is_left = limits;
  what_is_left.max_expanded_bytes = expansion_limit(bytes.size(), limits);
  auto read = read_expanded(expanded->bytes(), hints, what_is_left, corners);
  if (read) read->notes.gzip = true;
  return read;
}

}  // namespace

std::string_view to_string(Format format) {
  constexpr std::string_view kNames[] = {"obj", "stl", "ply", "off", "gltf", "glb", "3mf", "xyz", "arrays"};
  return kNames[static_cast<std::size_t>(format)];
}

Result<ReadMesh> read_mesh(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits,
                           Corners corners) {
  try {
    return is_gzip(bytes) ? read_gzip(bytes, hints, limits, corners) : read_expanded(bytes, hints, limits, corners);
  } catch (const std::bad_alloc&) {
    return out_of_memory(hints.part);
  }
}

}  // namespace meshgauge::api
