// The zip archive that a 3MF is, read where it lies in memory.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/file_path.h"
#include "api/formats/source.h"

namespace meshgauge::api {

// True when the bytes begin as a zip archive does, an empty one included.
bool is_zip(std::string_view text);

// What the library that reads zip archives takes for a file.
struct ZipMemory {
  std::span<const std::byte> bytes;
  std::size_t at = 0;
  bool short_read = false;  // the last one came to the end
  // What is read instead of the bytes from `record_at` on: a record of the directory (api/formats/zip64.h).
  std::size_t record_at = 0;
  std::vector<std::byte> record;
};

class ZipArchive {
 public:
  // Given the next expanded bytes of an entry; an Error ends it there.
  using Sink = std::function<std::optional<Error>(std::string_view piece)>;

  // Reads the directory, also that of Zip64; `source` is borrowed. Refused: an archive without a directory, more than
  // 10,000 entries, two entries of one name, an entry of 4 GiB or more. The names are taken without regard to case, as
  // the standard of such packages has it.
  static Result<ZipArchive> open(const Source& source);

  bool has(std::string_view name) const { return entries_.contains(file_key(name)); }

  std::vector<std::string> names() const;  // of all entries, in lower case, sorted

  // Of an entry once expanded, as it is announced; at most what may still be expanded. 0: there is no such entry.
  std::size_t announced_bytes(std::string_view name) const;

  // Expands one entry, piece by piece, never the whole of it. Refused: an entry that does not exist, is encrypted,
  // compressed by anything but deflate, or damaged (length and CRC are checked); and, over all the calls together,
  // more bytes than expansion_limit() allows.
  Result<Done> read(std::string_view name, const Sink& sink);

 private:
  struct Entry {
    std::uint64_t directory_offset = 0;
    std::uint64_t number = 0;
    std::uint64_t bytes = 0;  // expanded
    unsigned long method = 0;
    unsigned long flags = 0;
  };
  struct Close {
    void operator()(void* file) const;
  };

  explicit ZipArchive(const Source& source);
  Result<Done> read_directory();
  Result<Done> add_entry();
  Result<Done> check(std::string_view name, const Entry& entry) const;
  Result<Done> expand(std::string_view name, const Entry& entry, const Sink& sink);
  Error fail(std::string_view name, ErrorCode code, const std::string& what) const;

  const Source* source_;
  std::unique_ptr<ZipMemory> memory_;
  std::unique_ptr<void, Close> file_;
  std::map<std::string, Entry> entries_;
  std::size_t limit_;
  std::size_t left_;  // of limit_
};

}  // namespace meshgauge::api
