#include "api/formats/file/readers.h"

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "api/formats/detect.h"
#include "api/formats/file/file_path.h"
#include "api/formats/file/zip.h"
#include "api/formats/gltf/gltf_accessor.h"
#include "api/formats/gltf/gltf_archive.h"
#include "api/formats/gltf/gltf_document.h"
#include "api/formats/gltf/gltf_file.h"
#include "api/formats/gltf/gltf_scene.h"
#include "api/formats/gltf/gltf_views.h"

namespace meshgauge::api {
namespace {

Error fail(const Source& source, const std::string& where, const std::string& what) {
  return at(source, where, ErrorCode::unreadable_mesh, what);
}

// Returns file callbacks for tinygltf that open nothing. Its defaults open any file that a URI names; the documents
// that it gets name none.
tinygltf::FsCallbacks no_files() {
  tinygltf::FsCallbacks none{};
  none.FileExists = [](const std::string&, void*) { return false; };
  none.ExpandFilePath = [](const std::string&, void*) { return std::string(); };
  none.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; };
  none.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  return none;
}

Result<Done> load(const Source& source, const std::string& json, tinygltf::Model& model) {
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(no_files());
  loader.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  std::string error;
  std::string warning;
  if (json.size() > std::numeric_limits<unsigned>::max()) {
    return about(source.part, ErrorCode::too_large, "holds more than 4 GiB of JSON");
  }
  if (loader.LoadASCIIFromString(&model, &error, &warning, json.data(), static_cast<unsigned>(json.size()), "")) {
    return Done{};
  }
  return about(source.part, ErrorCode::unreadable_mesh, "is not a valid glTF: " + printable(error, 200));
}

using Bytes = std::span<const std::byte>;

constexpr std::string_view kDataUris[] = {"data:application/octet-stream;base64,",
                                          "data:application/gltf-buffer;base64,"};

bool has_gltf_media_type(std::string_view uri) {
  return std::ranges::any_of(kDataUris, [&](std::string_view start) { return uri.starts_with(start); });
}

// Reads data of any media type: a buffer has no other meaning.
Result<Bytes> decode_data_uri(const Source& source, const std::string& uri, const std::string& where,
                              std::vector<unsigned char>& decoded) {
  const std::size_t comma = uri.find(',');
  const bool known = has_gltf_media_type(uri);
  const bool base64 = comma != std::string::npos && std::string_view(uri).substr(0, comma).ends_with(";base64");
  std::string media_type;
  if (base64 && tinygltf::DecodeDataURI(&decoded, media_type,
                                        known ? uri : std::string(kDataUris[0]) + uri.substr(comma + 1), 0, false)) {
    return std::as_bytes(std::span(decoded));
  }
  return fail(source, where, "the data URI is not base64: expected 'data:application/octet-stream;base64,...'");
}

Result<Bytes> find_file(const Source& source, const GltfContainer& container, const std::string& uri,
                        const std::string& where) {
  const FilePath file = file_path_of_uri(uri);  // valid: check_gltf() checked it
  const std::string named = "names the file " + in_quotes(file.path);
  if (!container.file) {
    return fail(source, where,
                named +
                    ", which was not sent with it: put both into one .zip (or, over HTTP, send the file as a part "
                    "'a.files' or 'b.files')");
  }
  auto bytes = container.file(file.path);
  if (!bytes) return std::move(bytes).error();
  if (!*bytes) return fail(source, where, named + ", which is not among the files sent with it");
  return **bytes;
}

// Returns the bytes of each buffer: the BIN chunk, a file, or a data URI decoded into `decoded`. Fallback buffers stay
// empty, since the compressed data is read instead.
Result<std::vector<Bytes>> resolve_buffers(const Source& source, const GltfDocument& document,
                                           const GltfContainer& container,
                                           std::vector<std::vector<unsigned char>>& decoded) {
  std::vector<Bytes> out;
  decoded.reserve(document.buffers.size());  // spans point into it, so it must not grow
  for (const GltfBuffer& buffer : document.buffers) {
    const std::string where = gltf_item("buffers", out.size());
    if (buffer.fallback) {
      out.emplace_back();
      continue;
    }
    Result<Bytes> found = fail(source, where, "has no data: neither a URI nor a BIN chunk");
    if (buffer.is_external()) {
      found = find_file(source, container, buffer.uri, where);
    } else if (!buffer.uri.empty()) {
      found = decode_data_uri(source, buffer.uri, where, decoded.emplace_back());
    } else if (out.empty() && container.binary) {
      found = *container.binary;
    }
    if (!found) return std::move(found).error();
    if (const auto pointer = buffer.is_external() ? lfs_pointer(*found) : std::nullopt) {
      return at(source, where, ErrorCode::unsupported_format, in_quotes(buffer.uri) + " " + *pointer);
    }
    if (buffer.byte_length > found->size()) {
      return fail(source, where,
                  "byteLength is " + std::to_string(buffer.byte_length) + ", but there are " +
                      std::to_string(found->size()) + " bytes of data" +
                      (buffer.is_external() ? " in " + in_quotes(buffer.uri) : " (or they are not base64)"));
    }
    out.push_back(found->first(buffer.byte_length));
  }
  return out;
}

void add_remarks(const GltfDocument& document, const GltfContainer& container, ReadMesh& read) {
  const auto has_other_media_type = [](const GltfBuffer& buffer) {
    return buffer.uri.starts_with("data:") && !buffer.fallback && !has_gltf_media_type(buffer.uri);
  };
  read.notes.add_remark("bytes after the end of the GLB, ignored", container.trailing);
  read.notes.add_remark("buffers in data URIs of another media type than a glTF allows",
                        static_cast<std::size_t>(std::ranges::count_if(document.buffers, has_other_media_type)));
  read.notes.remarks.insert(read.notes.remarks.end(), document.remarks.begin(), document.remarks.end());
  read.unread = document.unread;
}

// `sent`: the file sent, which is the document or the archive that contains it.
Result<ReadMesh> read_scene(const Source& sent, const Source& source, const GltfContainer& container) {
  const auto document = check_gltf(source, container.json);
  if (!document) return document.error();
  tinygltf::Model model;
  if (auto ok = load(source, document->json, model); !ok) return std::move(ok).error();
  std::vector<std::vector<unsigned char>> decoded;
  const auto buffers = resolve_buffers(source, *document, container, decoded);
  if (!buffers) return buffers.error();
  GltfBudget budget(sent);
  GltfViews views(source, model, *document, *buffers, budget);
  const GltfAccessors accessors(source, model, views, document->quantized);
  auto read = read_gltf_scene({source, model, *document, views, accessors, budget});
  if (read) add_remarks(*document, container, *read);
  return read;
}

Result<ReadMesh> read_archive(const Source& source) {
  auto archive = GltfArchive::open(source);
  if (!archive) return std::move(archive).error();
  const Source scene{archive->scene(), source.part, source.limits};
  GltfContainer container = open_gltf(scene);
  container.file = [&](const std::string& path) { return archive->file(path); };
  auto read = read_scene(source, scene, container);
  if (read) read->format = Format::gltf;
  return read;
}

}  // namespace

Result<ReadMesh> read_gltf(const Source& source, Format format) {
  try {
    if (is_zip(source.text())) return read_archive(source);
    const auto container = format == Format::glb ? open_glb(source) : Result<GltfContainer>(open_gltf(source));
    if (!container) return container.error();
    auto read = read_scene(source, source, *container);
    if (read) read->format = format;
    return read;
  } catch (const std::bad_alloc&) {
    return out_of_memory(source.part);
  } catch (const std::exception& fault) {
    return about(source.part, ErrorCode::unreadable_mesh, "is not a valid glTF: " + printable(fault.what(), 200));
  }
}

}  // namespace meshgauge::api
