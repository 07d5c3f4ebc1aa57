// The reader of each format, and what tells the files of some formats apart. read_mesh() chooses among them; format.h
// has the guarantees of all.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "api/formats/file/source.h"

namespace meshgauge::api {

// Reads Wavefront OBJ: v and f statements. Points, lines and curves are counted as skipped; free-form surfaces,
// patches, included files and unknown statements as not read; what is no surface is ignored. A file of v without any of
// these is a point cloud. Accepts \n, \r\n and \r line ends, a byte order mark, continuation lines, relative indices,
// texture and normal indices (not looked up), vertex weights and colours (not used), faces before their vertices and,
// with a remark, NUL or 0x1A bytes at the end. Linear time.
Result<ReadMesh> read_obj(const Source& source);

// Reads STL, binary or ASCII, told apart by size and content; "solid" at the start is not trusted. Each facet gets
// three vertices of its own, in the file's order; those of a binary file are merged as weld() does if the source's
// corners may be. Normals and colours are not used.
Result<ReadMesh> read_stl(const Source& source);

// Returns true when the bytes can only be a binary STL: the count of facets at byte 80 gives the file's size, exactly
// or, with facets, up to 49 bytes less: less than a facet. No text has a count at byte 80 that fits its size.
bool is_binary_stl(std::span<const std::byte> bytes);

// Reads PLY 1.0: ASCII, binary little endian and binary big endian. Reads the elements "vertex" (x, y, z of any type),
// "face" and "tristrips" (vertex_indices or vertex_index, a list of any integer type; -1 ends a strip), in any order.
// Other elements and lists that may be surface are unread, the rest is ignored. Without anything that may join vertices
// it is a point cloud. Linear time.
Result<ReadMesh> read_ply(const Source& source);

// Reads OFF with any of the prefixes ST, C and N, in any order; each adds numbers to the line of a vertex. Normals,
// colours and texture coordinates are ignored. Accepts comments, blank lines, a missing edge count, faces over several
// lines, colours of faces and, with a remark, a file without the keyword whose first line has the counts, and NUL or
// 0x1A bytes at the end; and binary files, as Geomview defines them and in the variants that other programs write.
// Refuses other kinds (4OFF, nOFF) and other objects of Geomview (LIST, MESH) by name. Linear time.
Result<ReadMesh> read_off(const Source& source);

// Returns the keyword ("OFF", "COFF", "STCNOFF", "4OFF", ...) after any blanks, blank lines and comments; counts may
// follow without a space ("OFF8 6 12"). Empty: no keyword.
std::string_view off_keyword(std::string_view text);

// Returns the word of another object of Geomview than OFF at the start of a text without leading blanks and comments:
// "LIST", "CMESH", "BEZ133", "appearance"; "{" for an object in braces, but not for a JSON object. Empty: none.
// Constant time, except for the spaces and comments after a brace.
std::string_view geomview_object(std::string_view text);

// Reads glTF 2.0: JSON with data URIs (.gltf), GLB, or a zip archive of a .gltf and its files. Reads the triangles of
// the default scene (else of the first scene, else of all root nodes), with node transforms applied in double
// precision, skinned meshes in the pose of their joints' nodes and morph targets at their default weights. Opens
// nothing outside the bytes. Refuses unknown required extensions by name. Throws nothing.
Result<ReadMesh> read_gltf(const Source& source, Format format);

// Reads 3MF: a zip archive with models in XML. Reads the triangles of the build's items, components and instances with
// their transforms, in the model's unit (ReadNotes::unit); without transforms the coordinates are the file's own,
// bit-equal to strtod. Objects outside the build are counted and left out. Reads from memory, part by part; opens
// nothing outside the bytes. Refuses cycles of components, nesting beyond 64 and more than a million placed objects and
// components.
Result<ReadMesh> read_3mf(const Source& source);

inline constexpr const char* kRelationships = "_rels/.rels";  // an entry of every 3MF package

// Reads XYZ: a point cloud as text, one point a line. A line holds x, y and z, separated by blanks; what follows on it
// (normals, colours) is ignored. Skips empty lines, comments from # to the end of the line, and a byte order mark; with
// a remark, before the points, a heading that begins with X Y Z and a count of the points, and NUL or 0x1A bytes at the
// end. Refuses a heading of other columns and a wrong count. Linear time.
Result<ReadMesh> read_xyz(const Source& source);

}  // namespace meshgauge::api
