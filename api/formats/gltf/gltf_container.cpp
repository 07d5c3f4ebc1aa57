#include "api/formats/gltf/gltf_container.h"

#include <cstring>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kGlbHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kJson = 0x4E4F534A;
constexpr std::uint32_t kBinary = 0x004E4942;

std::uint32_t u32_at(const Source& source, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, source.bytes.data() + offset, sizeof word);
  return word;
}

Error fail_at(const Source& source, std::size_t offset, const std::string& what) {
  return at_byte(source, offset, ErrorCode::unreadable_mesh, "GLB: " + what);
}

std::string lengths(const Source& source) {
  return "the header says " + std::to_string(u32_at(source, 8)) + " bytes, the file has " +
         std::to_string(source.bytes.size());
}

// Returns the end of the GLB by its header.
Result<std::size_t> check_header(const Source& source) {
  if (!source.text().starts_with("glTF")) return fail_at(source, 0, "the file does not begin with 'glTF'");
  if (source.bytes.size() < kGlbHeaderBytes) return fail_at(source, source.bytes.size(), "truncated in the header");
  const std::uint32_t version = u32_at(source, 4);
  if (version == 1) return gltf_1_error(source);
  if (version != 2) {
    return at_byte(source, 4, ErrorCode::unsupported_format,
                   "GLB: version " + std::to_string(version) + " is not supported, only 2");
  }
  const std::size_t end = u32_at(source, 8);
  if (end > source.bytes.size()) return fail_at(source, 8, "truncated: " + lengths(source));
  if (end < kGlbHeaderBytes) return fail_at(source, 8, "left-over bytes: " + lengths(source));
  return end;
}

// Refuses a tail that holds more of a scene: another GLB, or a chunk, whose type follows its length.
Result<Done> check_tail(const Source& source, std::size_t end) {
  const std::string_view text = source.text();
  for (std::size_t at = end; (at = text.find("glTF", at)) != std::string_view::npos; at += 4) {
    const bool is_header = text.size() - at >= 8 && u32_at(source, at + 4) <= 2;
    if (at != end && !is_header) continue;
    return fail_at(source, at, "another GLB after the end of the first; write each to a file of its own");
  }
  for (const std::uint32_t type : {kJson, kBinary}) {
    const std::string_view word(reinterpret_cast<const char*>(&type), sizeof type);
    for (std::size_t at = end + 4; (at = text.find(word, at)) != std::string_view::npos; at += 4) {
      const bool fits = u32_at(source, at - 4) <= text.size() - at - 4;
      if (at != end + 4 && !fits) continue;
      return fail_at(source, at - 4, "left-over bytes: a chunk after the end: " + lengths(source));
    }
  }
  return Done{};
}

// Checks the place of a chunk: JSON first, BIN second; unknown types may follow.
Result<Done> take_chunk(const Source& source, std::size_t offset, std::size_t number, GltfContainer& out) {
  const std::size_t length = u32_at(source, offset);
  const std::uint32_t type = u32_at(source, offset + 4);
  const auto content = source.bytes.subspan(offset + kChunkHeaderBytes, length);
  if ((number == 0) != (type == kJson)) return fail_at(source, offset, "the first chunk, and no other, must be JSON");
  if (type == kJson) out.json = {reinterpret_cast<const char*>(content.data()), content.size()};
  if (type == kBinary && number != 1) return fail_at(source, offset, "a BIN chunk must be the second chunk");
  if (type == kBinary) out.binary = content;
  return Done{};
}

}  // namespace

Error gltf_1_error(const Source& source) {
  return about(source.part, ErrorCode::unsupported_format,
               "is of glTF 1.0, which is not supported; save the model as glTF 2.0");
}

Result<GltfContainer> open_glb(const Source& source) {
  const auto end = check_header(source);
  if (!end) return end.error();
  GltfContainer out;
  std::size_t number = 0;
  for (std::size_t offset = kGlbHeaderBytes; offset < *end; ++number) {
    const bool fits = *end - offset >= kChunkHeaderBytes && u32_at(source, offset) <= *end - offset - kChunkHeaderBytes;
    if (!fits && *end < source.bytes.size()) return fail_at(source, 8, "left-over bytes: " + lengths(source));
    if (*end - offset < kChunkHeaderBytes) return fail_at(source, offset, "truncated chunk header");
    const std::size_t length = u32_at(source, offset);
    if (!fits) {
      return fail_at(source, offset, "truncated: a chunk of " + std::to_string(length) + " bytes is announced");
    }
    if (auto ok = take_chunk(source, offset, number, out); !ok) return std::move(ok).error();
    offset += kChunkHeaderBytes + length;
  }
  if (auto ok = check_tail(source, *end); !ok) return std::move(ok).error();
  if (number == 0) return fail_at(source, kGlbHeaderBytes, "no JSON chunk");
  out.trailing = source.bytes.size() - *end;
  return out;
}

GltfContainer open_gltf(const Source& source) {
  GltfContainer out;
  out.json = std::string_view(after_mark(source.text()), source.end());
  return out;
}

}  // namespace meshgauge::api
