#include "api/formats/gltf/gltf_bundle.h"

#include <zlib.h>

#include <set>

#include "api/base/text.h"
#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_container.h"
#include "api/formats/gltf/gltf_document.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kLocalHeaderBytes = 30;
constexpr std::size_t kDirectoryRecordBytes = 46;
constexpr std::size_t kEndBytes = 22;
constexpr std::uint32_t kVersion = 20;       // version 2.0 of the zip format, which has folders
constexpr std::uint32_t kNamesUtf8 = 0x800;  // general purpose flag
constexpr std::uint32_t kFirstDay = 0x21;    // 1980-01-01 in the time stamps of DOS, whose midnight is 0

class Record {
 public:
  Record& u16(std::uint64_t value) { return number(value, 2); }
  Record& u32(std::uint64_t value) { return number(value, 4); }
  Record& text(std::string_view text) { return bytes_ += text, *this; }
  const std::string& bytes() const { return bytes_; }

 private:
  Record& number(std::uint64_t value, unsigned width) {
    for (unsigned i = 0; i < width; ++i) bytes_ += static_cast<char>((value >> (8 * i)) & 0xFFU);
    return *this;
  }

  std::string bytes_;
};

// Returns the fields shared by the header of an entry and its directory record.
Record& entry_facts(Record& record, std::string_view path, std::span<const std::byte> bytes, std::uint64_t crc) {
  record.u16(kVersion).u16(kNamesUtf8).u16(0).u16(0).u16(kFirstDay);
  return record.u32(crc).u32(bytes.size()).u32(bytes.size()).u16(path.size()).u16(0);
}

}  // namespace

bool is_gltf_json(std::span<const std::byte> bytes) {
  const std::string_view text = as_text(bytes);
  const char* const end = text.data() + text.size();
  const char* const first = skip_spaces(after_mark(text), end);
  return first != end && *first == '{';
}

bool is_scene_path(std::string_view path) {
  constexpr std::string_view kSuffix = ".gltf";
  return path.size() >= kSuffix.size() && same_word(path.substr(path.size() - kSuffix.size()), kSuffix);
}

std::vector<std::string> files_named_by(std::span<const std::byte> gltf) {
  const ReadLimits limits;
  const Source source{gltf, "a", limits};
  const auto document = check_gltf(source, open_gltf(source).json);
  if (!document) return {};
  std::set<std::string> paths;
  for (const GltfBuffer& buffer : document->buffers) {
    if (buffer.is_external()) paths.insert(file_path_of_uri(buffer.uri).path);
  }
  return {paths.begin(), paths.end()};
}

std::uint64_t BundleWriter::bytes_for(std::string_view path, std::uint64_t bytes) {
  return kLocalHeaderBytes + kDirectoryRecordBytes + 2 * path.size() + bytes;
}

std::uint64_t BundleWriter::bytes_for_end() { return kEndBytes; }

bool BundleWriter::put(std::string_view piece) {
  written_ += piece.size();
  return piece.empty() || sink_(piece);
}

bool BundleWriter::add(std::string_view path, std::span<const std::byte> bytes) {
  const std::uint64_t crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  Record recorded;
  recorded.u32(0x02014B50).u16(kVersion);
  entry_facts(recorded, path, bytes, crc).u16(0).u16(0).u16(0).u32(0).u32(written_).text(path);
  directory_ += recorded.bytes();
  ++entries_;
  Record header;
  header.u32(0x04034B50);
  return put(entry_facts(header, path, bytes, crc).text(path).bytes()) && put(as_text(bytes));
}

bool BundleWriter::finish() {
  Record end;
  end.u32(0x06054B50).u16(0).u16(0).u16(entries_).u16(entries_).u32(directory_.size()).u32(written_).u16(0);
  return put(directory_) && put(end.bytes());
}

}  // namespace meshgauge::api
