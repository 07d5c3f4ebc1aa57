#include "api/formats/detect.h"

#include <algorithm>
#include <string>

#include "api/base/text.h"
#include "api/formats/file/gzip.h"
#include "api/formats/file/readers.h"
#include "api/formats/file/source.h"
#include "api/formats/file/zip.h"
#include "api/formats/gltf/gltf_archive.h"
#include "api/formats/text/ply_header.h"

namespace meshgauge::api {
namespace {

struct Signature {
  std::string_view bytes;
  std::string_view what;
};
constexpr Signature kForeign[] = {
    {"\x89PNG", "is a PNG image, not a mesh"},
    {"\xFF\xD8\xFF", "is a JPEG image, not a mesh"},
    {"GIF8", "is a GIF image, not a mesh"},
    {"%PDF", "is a PDF document, not a mesh"},
    {"DRACO", "is a bare Draco file (.drc), which is not supported"},
    {"\x1F\x8B", "is gzip inside gzip, which is not supported"},
    {"BZh", "is compressed by bzip2, which is not supported; gzip is"},
    {"\xFD\x37zXZ", "is compressed by xz, which is not supported; gzip is"},
    {"\x28\xB5\x2F\xFD", "is compressed by zstd, which is not supported; gzip is"},
    {"7z\xBC\xAF", "is a 7z archive, not a mesh"},
    {"Rar!", "is a RAR archive, not a mesh"},
    {"Kaydara FBX", "is an FBX file, which is not supported"},
    {"; FBX", "is an FBX file, which is not supported"},
    {"AutoCAD Binary DXF", "is a DXF file, which is not supported"},
    {"3D Geometry File Format", "is a Rhino file (3DM), which is not supported"},
    {"xof 0", "is a DirectX file (X), which is not supported"},
    {"PXR-USDC", "is a USD file, which is not supported"},
    {"#usda 1", "is a USD file, which is not supported"},
    {"#VRML V", "is a VRML file, which is not supported"},
    {"#Inventor V", "is an Inventor file, which is not supported"},
    {"# vtk DataFile", "is a VTK file, which is not supported"},
    {"$MeshFormat", "is a Gmsh file, which is not supported"},
    {"BLENDER", "is a Blender file, which is not supported"},
    {"ISO-10303-21", "is a STEP file, which is not supported"},
    {"<?xml", "is an XML file (COLLADA, X3D, AMF or another), which is not supported"},
};

struct Name {
  std::string_view name;  // a file name extension, or a media type
  Format format;
};
constexpr Name kExtensions[] = {{"obj", Format::obj},      {"stl", Format::stl},   {"ply", Format::ply},
                                {"off", Format::off},      {"gltf", Format::gltf}, {"glb", Format::glb},
                                {"3mf", Format::three_mf}, {"xyz", Format::xyz}};
constexpr Name kMediaTypes[] = {{"model/obj", Format::obj},
                                {"text/prs.wavefront-obj", Format::obj},
                                {"model/stl", Format::stl},
                                {"application/sla", Format::stl},
                                {"model/x.stl-binary", Format::stl},
                                {"model/x.stl-ascii", Format::stl},
                                {"application/vnd.ms-pki.stl", Format::stl},
                                {"model/ply", Format::ply},
                                {"application/x-ply", Format::ply},
                                {"model/gltf+json", Format::gltf},
                                {"model/gltf-binary", Format::glb},
                                {"model/3mf", Format::three_mf},
                                {"application/vnd.ms-3mfdocument", Format::three_mf}};

std::string_view beginning(std::span<const std::byte> bytes, std::size_t count) {
  return as_text(bytes.first(std::min(bytes.size(), count)));
}

bool ends_with_word(std::string_view text, std::string_view lower_case) {
  return text.size() >= lower_case.size() && same_word(text.substr(text.size() - lower_case.size()), lower_case);
}

std::string_view without_gz(std::string_view filename) {
  return ends_with_word(filename, ".gz") ? filename.substr(0, filename.size() - 3) : filename;
}

std::optional<Format> format_by_hints(const ReadHints& hints) {
  if (const auto format = format_by_name(hints.filename)) return format;
  return format_by_media_type(hints.media_type);
}

// Returns true when the first statement is one of OBJ.
bool looks_like_obj(std::string_view text) {
  constexpr std::string_view kStatements[] = {"v", "vn", "vt", "vp",     "f",      "l",  "p",
                                              "o", "g",  "s",  "mtllib", "usemtl", "mg", "cstype"};
  const char* const end = text.data() + text.size();
  const char* p = after_mark(text);
  const auto is_comment = [end](const char* line) { return line != end && (*line == '#' || *line == '$'); };
  for (p = skip_spaces(p, end); is_comment(p); p = skip_spaces(p, end)) p = skip_line(p, end);
  const std::string_view word = word_at(p, end);
  return word.data() + word.size() != end && std::ranges::find(kStatements, word) != std::end(kStatements);
}

std::optional<Format> format_by_content(std::span<const std::byte> bytes) {
  constexpr std::size_t kEnough = std::size_t{64} << 10U;  // covers the comments at the start of most OBJ files
  const std::string_view start = beginning(bytes, kEnough);
  if (start.starts_with("glTF")) return Format::glb;
  if (is_zip(start)) return holds_gltf(bytes) ? Format::gltf : Format::three_mf;
  if (is_ply(start)) return Format::ply;
  if (!off_keyword(start).empty()) return Format::off;
  if (is_binary_stl(bytes)) return Format::stl;
  if (looks_like_obj(start)) return Format::obj;
  const char* const p = skip_spaces(after_mark(start), start.data() + start.size());
  const std::string_view word = word_at(p, start.data() + start.size());
  if (word.starts_with('{')) {
    return geomview_object({p, start.data() + start.size()}).empty() ? Format::gltf : Format::off;
  }
  if (same_word(word, "solid")) return Format::stl;
  return std::nullopt;
}

bool is_web_page(std::string_view start) {
  const char* p = skip_spaces(start.data(), start.data() + start.size());
  start.remove_prefix(static_cast<std::size_t>(p - start.data()));
  return same_word(start.substr(0, 9), "<!doctype") || same_word(start.substr(0, 5), "<html");
}

// Detects UTF-16 by its byte order mark, or because every other byte of the beginning is NUL.
bool is_utf16(std::string_view start) {
  if (start.starts_with("\xFF\xFE") || start.starts_with("\xFE\xFF")) return true;
  if (start.size() < 8) return false;
  const auto nul_at = [&](std::size_t parity) {
    for (std::size_t i = 0; i < 8; ++i) {
      if ((start[i] == '\0') != (i % 2 == parity)) return false;
    }
    return true;
  };
  return nul_at(0) || nul_at(1);
}

// Returns true when the first words after comments are group 0, SECTION.
bool is_dxf(std::string_view start) {
  const char* const end = start.data() + start.size();
  const auto word = [end](const char* p) { return word_at(skip_spaces(p, end), end); };
  std::string_view group = word(start.data());
  while (group == "999") {  // a comment, on the line below
    group = word(next_line(next_line(group.data(), end), end));
  }
  return group == "0" && word(group.data() + group.size()) == "SECTION";
}

// Returns true for the main chunk with its size, followed by the version or the editor's chunk.
bool is_3ds(std::span<const std::byte> bytes) {
  const std::string_view start = beginning(bytes, 8);
  const std::string_view inner = start.substr(std::min<std::size_t>(6, start.size()));
  return start.starts_with("MM") && (inner == std::string_view("\x02\0", 2) || inner == "==") && !is_binary_stl(bytes);
}

// Returns true for lines of 80 characters, the first in section S.
bool is_iges(std::string_view start) {
  return start.size() > 80 && start.substr(72, 8) == "S      1" && is_newline(start[80]);
}

bool is_text_format(Format format) {
  return format == Format::obj || format == Format::off || format == Format::gltf || format == Format::xyz;
}

std::optional<std::string> foreign_kind(std::span<const std::byte> bytes) {
  if (bytes.empty()) return "is an empty file";
  const std::string_view start = beginning(bytes, 4096);
  for (const Signature& foreign : kForeign) {
    // The header of a binary STL is free text.
    if (start.starts_with(foreign.bytes) && !is_binary_stl(bytes)) return std::string(foreign.what);
  }
  if (auto pointer = lfs_pointer(bytes)) return pointer;
  if (is_dxf(start)) return "is a DXF file, which is not supported";
  if (is_3ds(bytes)) return "is a 3DS file, which is not supported";
  if (is_iges(start)) return "is an IGES file, which is not supported";
  if (is_web_page(start)) return "is a web page (HTML), not a mesh";
  if (is_utf16(start)) return "is text in UTF-16, which is not supported; UTF-8 is";
  return std::nullopt;
}

}  // namespace

std::optional<Format> format_by_name(std::string_view filename) {
  filename = without_gz(filename);
  const std::size_t dot = filename.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  for (const Name& known : kExtensions) {
    if (same_word(filename.substr(dot + 1), known.name)) return known.format;
  }
  return std::nullopt;
}

std::optional<Format> format_by_media_type(std::string_view media_type) {
  media_type = media_type.substr(0, media_type.find(';'));
  while (media_type.ends_with(' ')) media_type.remove_suffix(1);
  for (const Name& known : kMediaTypes) {
    if (same_word(media_type, known.name)) return known.format;
  }
  return std::nullopt;
}

std::optional<std::string> lfs_pointer(std::span<const std::byte> bytes) {
  for (const char* site : {"git-lfs", "hawser"}) {  // hawser: the older name
    const std::string line = std::string("version https://") + site + ".github.com/spec/";
    if (!beginning(bytes, line.size()).starts_with(line)) continue;
    return std::string(kLfsPointer) + ", " + std::string(kNoMesh) + ": 'git lfs pull' puts the file in its place";
  }
  return std::nullopt;
}

std::optional<Error> refuse_foreign(std::span<const std::byte> bytes, const ReadHints& hints) {
  if (auto kind = foreign_kind(bytes)) {
    const ErrorCode code = bytes.empty() ? ErrorCode::empty_mesh : ErrorCode::unsupported_format;
    return about(hints.part, code, *kind);
  }
  const auto by_name = format_by_hints(hints);
  const std::size_t text_end = length_without_padding(as_text(bytes));
  const bool binary =
      beginning(text_end > 0 ? bytes.first(text_end) : bytes, 4096).find('\0') != std::string_view::npos;
  if (binary && by_name && is_text_format(*by_name) && !format_by_content(bytes)) {
    return about(hints.part, ErrorCode::unsupported_format,
                 "holds binary data, not " + std::string(to_string(*by_name)) + " as its name says");
  }
  return std::nullopt;
}

std::optional<Format> detect_format(std::span<const std::byte> bytes, const ReadHints& hints) {
  if (const auto format = format_by_content(bytes)) return format;
  return format_by_hints(hints);
}

}  // namespace meshgauge::api
