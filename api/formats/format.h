// One function for every mesh file: read_mesh(bytes, hints, limits). One reader a format behind it.
//
// What every reader promises (docs/formats.md):
//   * coordinates are the file's own numbers: text correctly rounded (bit-equal to strtod), binary exact;
//   * counts are checked against the bytes that remain before anything is allocated;
//   * NaN, infinity, trailing rubbish in a number and an index out of range are refused, with line or byte;
//   * faces of more corners are split into triangles (api/formats/polygons.h); degenerate triangles are kept;
//   * nothing outside the bytes is ever opened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/units.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

enum class Format { obj, stl, ply, off, gltf, glb, three_mf };

std::string_view to_string(Format format);  // "obj", "stl", "ply", "off", "gltf", "glb", "3mf"

struct ReadLimits {
  std::size_t max_vertices = 200'000'000;
  std::size_t max_triangles = 100'000'000;
  std::size_t max_expanded_bytes = std::size_t{4} << 30;  // of a gzip-compressed file or a 3MF, once expanded
};

// Faces of more than three corners, and how they were split into triangles.
struct PolygonNotes {
  std::size_t count = 0;
  std::size_t concave = 0;
  std::size_t non_planar = 0;
  std::size_t self_crossing = 0;
  double largest_deviation = 0;  // how far two splits of one face can be apart, rounded up; in the file's unit

  bool operator==(const PolygonNotes&) const = default;
};

// What a reader did to the file beyond reading it; the result reports all of it.
struct ReadNotes {
  bool gzip = false;  // the file was gzip-compressed
  PolygonNotes polygons;
  std::size_t skipped_primitives = 0;  // points, lines, joins of strips: they have no surface
  std::size_t welded_vertices = 0;     // joined with another of the same position; by read_part() alone
  std::size_t unused_objects = 0;      // objects of a 3MF outside of its build, meshes of a glTF outside of its scene
  std::size_t helper_objects = 0;  // objects and volumes of a 3MF that are not printed: support, modifiers, blockers
  std::optional<LengthUnit> unit;  // named by the file or fixed by its format
  // What the hints say, where the content is of another format.
  std::optional<Format> filename_says;
  std::optional<Format> media_type_says;
  // One sentence each, printable ASCII: what no field above has room for.
  std::vector<std::string> remarks;
};

inline constexpr std::size_t kMaxRemarks = 16;
inline constexpr std::size_t kMaxRemarkBytes = 256;

struct ReadHints {
  std::string_view part;        // "a" or "b", for messages
  std::string_view filename;    // may be empty
  std::string_view media_type;  // may be empty
};

struct ReadMesh {
  Mesh mesh;
  Format format = Format::obj;
  ReadNotes notes;
};

// The format by content first, then by file name and media type. nullopt: none is recognised.
std::optional<Format> detect_format(std::span<const std::byte> bytes, const ReadHints& hints);

// Reads a whole file. An Error names part, line or byte. Guarantee: the mesh passes validate() within `limits`.
// Thread safe, no global state.
Result<ReadMesh> read_mesh(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits);

}  // namespace meshgauge::api
