// Helpers for tests of the readers: texts as files, files of the corpus, outcomes in one line.
#pragma once

#include <array>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/format.h"

namespace meshgauge::api::test {

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

inline Result<ReadMesh> read(std::string_view content, std::string_view filename, const ReadLimits& limits = {},
                             Corners corners = Corners::apart) {
  // A copy of exactly the content, so that a sanitizer sees every read beyond it.
  const std::vector<char> exact(content.begin(), content.end());
  return read_mesh(std::as_bytes(std::span<const char>(exact)), ReadHints{"a", filename, ""}, limits, corners);
}

// Returns the message of the refusal; empty: the file was read.
inline std::string refusal(std::string_view content, std::string_view filename) {
  auto result = read(content, filename);
  return result ? std::string() : result.error().message;
}

inline std::optional<ErrorCode> code(std::string_view content, std::string_view filename) {
  auto result = read(content, filename);
  if (result) return std::nullopt;
  return result.error().code;
}

inline bool contains(std::string_view text, std::string_view piece) {
  return text.find(piece) != std::string_view::npos;
}

template <class T>
std::string raw(T value) {
  std::string out(sizeof value, '\0');
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}

std::string base64(std::string_view data);

// The corpus' folder, if there is one: $MESHGAUGE_CORPUS, or beside the project.
std::optional<std::filesystem::path> corpus();

std::string file_content(const std::filesystem::path& path);

// Returns the file or, for a .gltf that names files beside it, the archive of all of them.
std::string bundled_content(const std::filesystem::path& path);

// Returns the rows of a tab-separated table without its heading.
std::vector<std::vector<std::string>> table(const std::filesystem::path& path);

}  // namespace meshgauge::api::test
