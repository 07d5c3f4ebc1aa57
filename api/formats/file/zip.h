// Reads zip archives from memory: 3MF, and .gltf with its files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/file/file_path.h"
#include "api/formats/file/source.h"

namespace meshgauge::api {

// Returns true when the bytes begin like a zip archive, including an empty one.
bool is_zip(std::string_view text);

// Returns a directory record of a Zip64 archive as that of a plain one: the record that begins at byte `at`, to the end
// of its extra fields, with the sizes and the offset of its Zip64 field in their plain places and that field's id
// changed to an unused one. Empty: no record begins there, it has no Zip64 field in use, or the field is damaged or
// holds a number of 4 GiB or more. minizip 1.1 (Debian 12) leaves the sizes of such entries at 0xFFFFFFFF; later
// versions also read the rewritten records.
std::vector<std::byte> plain_zip_record(std::span<const std::byte> archive, std::size_t at);

// The archive's bytes as a file for minizip.
struct ZipMemory {
  std::span<const std::byte> bytes;
  std::size_t at = 0;
  bool short_read = false;   // true: the last read reached the end
  bool in_directory = true;  // false: an entry's own bytes are read, whatever they look like
  // A directory record that replaces the bytes from `record_at` on.
  std::size_t record_at = 0;
  std::vector<std::byte> record;
};

class ZipArchive {
 public:
  // Takes the next expanded bytes of an entry; an Error ends the reading.
  using Sink = std::function<std::optional<Error>(std::string_view piece)>;

  // Reads the directory, also of Zip64; borrows `source`. Refuses an archive without a directory, more than 10,000
  // entries, two entries of one name and an entry of 4 GiB or more. Names are compared without regard to case, as the
  // Open Packaging Conventions require.
  static Result<ZipArchive> open(const Source& source);

  bool has(std::string_view name) const { return entries_.contains(file_key(name)); }

  std::vector<std::string> names() const;  // names of all entries, in lower case, sorted

  // Takes '\' in names for the '/' that the format prescribes; returns the number of such entries. Refuses two entries
  // of one name then.
  Result<std::size_t> join_backslashes();

  // Returns the expanded size of an entry by its directory, at most the bytes that may still be expanded. 0: no such
  // entry.
  std::size_t announced_bytes(std::string_view name) const;

  // Expands one entry piece by piece. Refuses an entry that does not exist, is encrypted, is compressed by anything but
  // deflate or is damaged (length and CRC are checked), and more than expansion_limit() bytes over all calls.
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
  std::size_t left_;  // bytes of limit_ not used yet
};

}  // namespace meshgauge::api
