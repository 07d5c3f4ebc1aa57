// Which format a file is, and in what words a file that is no mesh is refused. detect_format() is in format.h.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "api/formats/format.h"

namespace meshgauge::api {

// What the name of a file (`.gz` taken off) or a media type says. nullopt: nothing of a mesh.
std::optional<Format> format_by_name(std::string_view filename);
std::optional<Format> format_by_media_type(std::string_view media_type);

// Parts of the messages of refuse_foreign(), by which `meshgauge check` tells what helps.
inline constexpr std::string_view kLfsPointer = "is a Git LFS pointer";
inline constexpr std::string_view kNoMesh = "not a mesh";

// What a pointer of Git LFS is told to be; nullopt: `bytes` are none. It is the text that stands in a checkout for a
// file that is kept elsewhere.
std::optional<std::string> lfs_pointer(std::span<const std::byte> bytes);

// Why `bytes`, a file or its beginning, cannot be a mesh that is read here: a web page, an image, an archive,
// text in UTF-16, Draco, binary data under the name of a text format. nullopt: it may be one.
std::optional<Error> refuse_foreign(std::span<const std::byte> bytes, const ReadHints& hints);

}  // namespace meshgauge::api
