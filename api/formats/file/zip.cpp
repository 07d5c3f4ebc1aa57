#include "api/formats/file/zip.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include <minizip/unzip.h>

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "zip archives are read as the machine's own integers");

// A directory record: the bytes before its name, and places in them.
constexpr std::size_t kFixedBytes = 46;
constexpr std::size_t kNameLengthAt = 28;
constexpr std::size_t kExtraLengthAt = 30;
// Places of size, packed size and offset in the record. The Zip64 field has them in this order, each only if its plain
// place holds 0xFFFFFFFF.
constexpr std::size_t kPlacesInOrder[] = {24, 20, 42};
constexpr std::uint32_t kElsewhere = 0xFFFFFFFF;
constexpr std::uint16_t kZip64 = 0x0001;
constexpr std::uint16_t kNoMeaning = 0x0000;

template <class Integer>
Integer integer_at(std::span<const std::byte> bytes, std::size_t at) {
  Integer value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class Integer>
void put(std::span<std::byte> bytes, std::size_t at, Integer value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

// Returns the place of the Zip64 field among the extra fields; nullopt: none.
std::optional<std::size_t> find_zip64(std::span<const std::byte> record, std::size_t at) {
  while (at + 4 <= record.size()) {
    const std::size_t next = at + 4 + integer_at<std::uint16_t>(record, at + 2);
    if (next > record.size()) return std::nullopt;
    if (integer_at<std::uint16_t>(record, at) == kZip64) return at;
    at = next;
  }
  return std::nullopt;
}

// Copies numbers from the Zip64 field to their plain places. false: one is missing or too large.
bool put_in_place(std::span<std::byte> record, std::size_t field) {
  const std::size_t end = field + 4 + integer_at<std::uint16_t>(record, field + 2);
  std::size_t at = field + 4;
  for (const std::size_t place : kPlacesInOrder) {
    if (integer_at<std::uint32_t>(record, place) != kElsewhere) continue;
    if (at + 8 > end) return false;
    const auto value = integer_at<std::uint64_t>(record, at);
    if (value >= kElsewhere) return false;
    put(record, place, static_cast<std::uint32_t>(value));
    at += 8;
  }
  put(record, field, kNoMeaning);
  return true;
}

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

std::vector<std::byte> plain_zip_record(std::span<const std::byte> archive, std::size_t at) {
  if (at > archive.size() || archive.size() - at < kFixedBytes) return {};
  const auto rest = archive.subspan(at);
  if (std::memcmp(rest.data(), "PK\x01\x02", 4) != 0) return {};
  bool full = false;
  for (const std::size_t place : kPlacesInOrder) full |= integer_at<std::uint32_t>(rest, place) == kElsewhere;
  const std::size_t extra = kFixedBytes + integer_at<std::uint16_t>(rest, kNameLengthAt);
  const std::size_t bytes = extra + integer_at<std::uint16_t>(rest, kExtraLengthAt);
  if (!full || bytes > rest.size()) return {};
  std::vector<std::byte> record(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(bytes));
  const auto field = find_zip64(record, extra);
  if (!field || !put_in_place(record, *field)) return {};
  return record;
}

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
