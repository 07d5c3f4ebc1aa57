#include "api/formats/zip.h"

#include <algorithm>
#include <array>
#include <utility>

#include <minizip/unzip.h>

#include "api/formats/expansion.h"
#include "api/formats/zip64.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kMostEntries = 10'000;
constexpr std::size_t kLongestName = 1024;
constexpr std::size_t kPieceBytes = std::size_t{64} << 10U;

ZipMemory& as_memory(void* file) { return *static_cast<ZipMemory*>(file); }

void* open_memory(void* memory, const void* /*path*/, int /*mode*/) { return memory; }

uLong read_memory(void* /*opaque*/, void* file, void* to, uLong count) {
  ZipMemory& memory = as_memory(file);
  const auto rest = memory.bytes.subspan(memory.at);
  const std::size_t most = std::min<std::size_t>(count, rest.size());
  auto* const out = static_cast<std::byte*>(to);
  std::copy_n(rest.begin(), most, out);
  const std::size_t from = std::max(memory.at, memory.record_at);
  const std::size_t end = std::min(memory.at + most, memory.record_at + memory.record.size());
  if (from < end) std::copy_n(&memory.record[from - memory.record_at], end - from, out + (from - memory.at));
  memory.at += most;
  memory.short_read = most < count;
  return most;
}

uLong write_nothing(void* /*opaque*/, void* /*file*/, const void* /*from*/, uLong /*count*/) { return 0; }

// Offsets come from the archive and are not trusted.
long seek_memory(void* /*opaque*/, void* file, ZPOS64_T offset, int origin) {
  ZipMemory& memory = as_memory(file);
  std::size_t base = 0;
  if (origin == ZLIB_FILEFUNC_SEEK_CUR) base = memory.at;
  if (origin == ZLIB_FILEFUNC_SEEK_END) base = memory.bytes.size();
  if (offset > memory.bytes.size() - base) return -1;
  memory.at = base + offset;
  // minizip seeks to a directory record from the start of the archive, then reads it.
  if (origin == ZLIB_FILEFUNC_SEEK_SET) {
    memory.record_at = memory.at;
    memory.record = memory.in_directory ? plain_zip_record(memory.bytes, memory.at) : std::vector<std::byte>{};
  }
  return 0;
}

ZPOS64_T tell_memory(void* /*opaque*/, void* file) { return as_memory(file).at; }

int close_nothing(void* /*opaque*/, void* /*file*/) { return 0; }

// minizip calls this after a read that reached the end. Without an error it would continue with a byte that it did not
// get.
int error_of(void* /*opaque*/, void* file) { return as_memory(file).short_read ? 1 : 0; }

}  // namespace

bool is_zip(std::string_view text) { return text.starts_with("PK\x03\x04") || text.starts_with("PK\x05\x06"); }

void ZipArchive::Close::operator()(void* file) const { unzClose(file); }

ZipArchive::ZipArchive(const Source& source)
    : source_(&source),
      memory_(std::make_unique<ZipMemory>()),
      limit_(expansion_limit(source.bytes.size(), source.limits)),
      left_(limit_) {
  memory_->bytes = source.bytes;
  zlib_filefunc64_def calls{open_memory, read_memory,   write_nothing, tell_memory,
                            seek_memory, close_nothing, error_of,      memory_.get()};
  file_.reset(unzOpen2_64("", &calls));
}

std::vector<std::string> ZipArchive::names() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) names.push_back(name);
  return names;
}

std::size_t ZipArchive::announced_bytes(std::string_view name) const {
  const auto found = entries_.find(file_key(name));
  return found == entries_.end() ? 0 : static_cast<std::size_t>(std::min<std::uint64_t>(found->second.bytes, left_));
}

Error ZipArchive::fail(std::string_view name, ErrorCode code, const std::string& what) const {
  return at(*source_, printable(name, 100), code, what);
}

Result<ZipArchive> ZipArchive::open(const Source& source) {
  ZipArchive archive(source);
  if (!archive.file_) {
    return about(source.part, ErrorCode::unreadable_mesh,
                 "is a zip archive without a directory at its end: truncated or damaged");
  }
  if (auto ok = archive.read_directory(); !ok) return std::move(ok).error();
  return archive;
}

Result<Done> ZipArchive::read_directory() {
  unz_global_info64 info{};
  unzGetGlobalInfo64(file_.get(), &info);
  if (info.number_entry == 0) return Done{};
  int status = unzGoToFirstFile(file_.get());
  for (; status == UNZ_OK; status = unzGoToNextFile(file_.get())) {
    if (entries_.size() == kMostEntries) {
      return about(source_->part, ErrorCode::too_large, "is a zip archive of more than 10000 entries");
    }
    if (auto ok = add_entry(); !ok) return ok;
  }
  if (status == UNZ_END_OF_LIST_OF_FILE) return Done{};
  return about(source_->part, ErrorCode::unreadable_mesh,
               "is a zip archive with a damaged directory, after " + std::to_string(entries_.size()) + " entries");
}

Result<Done> ZipArchive::add_entry() {
  unz_file_info64 info{};
  std::array<char, kLongestName> name{};
  unz64_file_pos place{};
  const bool told =
      unzGetCurrentFileInfo64(file_.get(), &info, name.data(), name.size(), nullptr, 0, nullptr, 0) == UNZ_OK &&
      unzGetFilePos64(file_.get(), &place) == UNZ_OK;
  if (!told || info.size_filename > name.size()) {
    return about(source_->part, ErrorCode::unreadable_mesh,
                 "is a zip archive with a damaged entry, or a name of more than 1024 bytes");
  }
  const std::string_view whole(name.data(), info.size_filename);
  constexpr ZPOS64_T kMostBytes = 0xFFFFFFFE;
  if (std::max(info.compressed_size, info.uncompressed_size) > kMostBytes) {
    return fail(whole, ErrorCode::too_large, "an entry of 4 GiB or more, or a damaged Zip64 field");
  }
  const Entry entry{place.pos_in_zip_directory, place.num_of_file, info.uncompressed_size, info.compression_method,
                    info.flag};
  if (!entries_.try_emplace(file_key(whole), entry).second) {
    return fail(whole, ErrorCode::unreadable_mesh, "occurs twice in the zip archive");
  }
  return Done{};
}

Result<std::size_t> ZipArchive::join_backslashes() {
  std::map<std::string, Entry> entries;
  std::size_t renamed = 0;
  for (const auto& [name, entry] : entries_) {
    std::string joined = name;
    std::ranges::replace(joined, '\\', '/');
    if (joined != name) ++renamed;
    if (entries.try_emplace(std::move(joined), entry).second) continue;
    return fail(name, ErrorCode::unreadable_mesh,
                "occurs twice in the zip archive, with '/' and with '\\' between folders");
  }
  entries_ = std::move(entries);
  return renamed;
}

Result<Done> ZipArchive::check(std::string_view name, const Entry& entry) const {
  constexpr unsigned long kEncrypted = 0x2041;  // flags of three kinds of encryption
  if ((entry.flags & kEncrypted) != 0) return fail(name, ErrorCode::unsupported_format, "encrypted");
  if (entry.method != 0 && entry.method != Z_DEFLATED) {
    return fail(name, ErrorCode::unsupported_format,
                "compressed by method " + std::to_string(entry.method) + "; only deflate is supported");
  }
  return Done{};
}

Result<Done> ZipArchive::read(std::string_view name, const Sink& sink) {
  const auto found = entries_.find(file_key(name));
  if (found == entries_.end()) return fail(name, ErrorCode::unreadable_mesh, "missing from the zip archive");
  const Entry& entry = found->second;
  if (auto ok = check(name, entry); !ok) return ok;
  const unz64_file_pos place{entry.directory_offset, entry.number};
  memory_->in_directory = true;
  const bool found_again = unzGoToFilePos64(file_.get(), &place) == UNZ_OK;
  memory_->in_directory = false;
  if (!found_again || unzOpenCurrentFile(file_.get()) != UNZ_OK) {
    return fail(name, ErrorCode::unreadable_mesh, "the entry of the zip archive and its directory do not agree");
  }
  auto ok = expand(name, entry, sink);
  const int closed = unzCloseCurrentFile(file_.get());
  if (ok && closed != UNZ_OK) return fail(name, ErrorCode::unreadable_mesh, "damaged: its CRC does not match");
  return ok;
}

Result<Done> ZipArchive::expand(std::string_view name, const Entry& entry, const Sink& sink) {
  std::vector<char> piece(kPieceBytes);
  std::uint64_t expanded = 0;
  for (;;) {
    const int count = unzReadCurrentFile(file_.get(), piece.data(), kPieceBytes);
    if (count == 0) break;
    if (count < 0) {
      return fail(name, ErrorCode::unreadable_mesh,
                  "damaged or truncated after " + std::to_string(expanded) + " expanded bytes");
    }
    const auto bytes = static_cast<std::size_t>(count);
    if (bytes > left_) return expands_too_far(source_->part, limit_, source_->bytes.size(), "zip");
    left_ -= bytes;
    expanded += bytes;
    if (auto error = sink({piece.data(), bytes})) return std::move(*error);
  }
  // minizip checks the CRC only if all bytes were read.
  if (expanded == entry.bytes) return Done{};
  return fail(
      name, ErrorCode::unreadable_mesh,
      "truncated: " + std::to_string(entry.bytes) + " bytes are announced, " + std::to_string(expanded) + " were read");
}

}  // namespace meshgauge::api
