// Reads mesh files of every format: read_mesh(bytes, hints, limits), with one reader for each format.
//
// Guarantees of every reader (docs/formats.md):
//   * coordinates are the file's own numbers: text correctly rounded (bit-equal to strtod), binary exact;
//   * counts are checked against the remaining bytes before memory is allocated;
//   * NaN, infinity, trailing characters in a number and an index out of range are refused, with line or byte;
//   * faces of more than three corners are split into triangles (api/formats/polygons/polygons.h);
//   * degenerate triangles are kept;
//   * a file of points alone is read as a point cloud;
//   * what describes surface and is not read is a remark, or a refusal if there is no other surface;
//   * nothing outside the bytes is opened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/units.h"
#include "api/formats/groups.h"
#include "api/formats/unread.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

enum class Format {
  obj,
  stl,
  ply,
  off,
  gltf,
  glb,
  three_mf,
  xyz,
  arrays,  // no file: arrays in memory
};

std::string_view to_string(Format format);  // "obj", "stl", "ply", "off", "gltf", "glb", "3mf", "xyz", "arrays"

struct ReadLimits {
  std::size_t max_vertices = 200'000'000;
  std::size_t max_triangles = 100'000'000;
  std::uint64_t max_expanded_bytes = std::uint64_t{4} << 30;  // expanded size of a gzip-compressed file or a 3MF
};

// For files of clients that are not trusted: the defaults of the service's settings.
inline constexpr ReadLimits kUntrustedLimits{50'000'000, 50'000'000, std::uint64_t{2} << 30};
inline constexpr std::uint64_t kUntrustedFileBytes = std::uint64_t{4} << 30;

// Counts of faces of more than three corners, and how far their splits into triangles may differ.
struct PolygonNotes {
  std::size_t count = 0;
  std::size_t concave = 0;
  std::size_t non_planar = 0;
  std::size_t self_crossing = 0;
  double largest_deviation = 0;  // most that two splits of one face can be apart, rounded up; in the file's unit

  bool operator==(const PolygonNotes&) const = default;
};

// What a reader changed or left out; the result reports all of it.
struct ReadNotes {
  bool gzip = false;   // the file was gzip-compressed
  bool cloud = false;  // points without faces: the mesh's triangles are its points (engine/mesh.h)
  PolygonNotes polygons;
  std::size_t skipped_primitives = 0;  // points, lines, joins of strips: without a surface
  std::size_t welded_vertices = 0;  // merged with a vertex of the same position: by read_part(), or if ReadMesh::merged
  std::size_t unused_objects = 0;   // objects of a 3MF outside its build, meshes of a glTF outside its scene
  std::size_t helper_objects = 0;   // objects and volumes of a 3MF that are not printed: support, modifiers, blockers
  std::optional<LengthUnit> unit;   // named by the file or fixed by its format; nullopt: not known
  // The format by a hint, only if the content is of another format.
  std::optional<Format> filename_says;
  std::optional<Format> media_type_says;
  // Further notes, one sentence each, printable ASCII.
  std::vector<std::string> remarks;

  // Adds the remark "what: count", unless the count is 0.
  void add_remark(const std::string& what, std::size_t count) {
    if (count != 0) remarks.push_back(what + ": " + std::to_string(count));
  }
};

inline constexpr std::size_t kMaxRemarks = 16;
inline constexpr std::size_t kMaxRemarkBytes = 256;

struct ReadHints {
  std::string_view part;        // name of the input in messages: "a" or "b"
  std::string_view filename;    // may be empty
  std::string_view media_type;  // may be empty
};

// What a reader does with the corners of a format that stores three vertices for each triangle.
enum class Corners {
  apart,   // keeps three vertices for each triangle, with the file's own numbers
  merged,  // may merge equal positions while it reads, as weld() does (api/formats/weld.h)
};

struct ReadMesh {
  Mesh mesh;
  bool merged = false;  // equal positions are one vertex, and notes.welded_vertices counts the others
  Format format = Format::obj;
  ReadNotes notes;
  Unread unread;  // only from a reader to read_mesh(), which makes remarks or a refusal of it
  Groups groups;
};

// Detects the format by content first, then by file name and media type. nullopt: not recognised.
std::optional<Format> detect_format(std::span<const std::byte> bytes, const ReadHints& hints);

// Reads a whole file. The mesh passes validate() within `limits`. Errors name the part and the line or byte. Thread
// safe, no global state.
Result<ReadMesh> read_mesh(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits,
                           Corners corners = Corners::apart);

}  // namespace meshgauge::api
