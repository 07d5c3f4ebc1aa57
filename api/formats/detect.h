// Recognises formats by name and media type, and refuses files that are not meshes. detect_format() is in format.h.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "api/formats/format.h"

namespace meshgauge::api {

// Returns the format that a file name (without `.gz`) or a media type stands for. nullopt: not that of a mesh format.
std::optional<Format> format_by_name(std::string_view filename);
std::optional<Format> format_by_media_type(std::string_view media_type);

// Parts of the messages of refuse_foreign(); `meshgauge check` chooses its advice by them.
inline constexpr std::string_view kLfsPointer = "is a Git LFS pointer";
inline constexpr std::string_view kNoMesh = "not a mesh";

// Returns the message for a Git LFS pointer: the text that a checkout has in place of a file stored elsewhere. nullopt:
// `bytes` are not such a pointer.
std::optional<std::string> lfs_pointer(std::span<const std::byte> bytes);

// Returns the reason why `bytes`, a file or its beginning, cannot be a mesh that is read here: a web page, an image, an
// archive, UTF-16 text, Draco, binary data under the name of a text format. nullopt: it may be a mesh.
std::optional<Error> refuse_foreign(std::span<const std::byte> bytes, const ReadHints& hints);

}  // namespace meshgauge::api
