// The bytes of one uploaded file: up to 256 KiB in memory, more in an unnamed temporary file.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/problem.h"
#include "server/sandbox/descriptor.h"

namespace meshgauge::server {

// Limits the bytes that all uploads hold together. Thread safe.
class ByteBudget {
 public:
  explicit ByteBudget(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  bool take(std::uint64_t bytes);  // false: the limit would be exceeded; nothing is taken
  void give(std::uint64_t bytes) { used_.fetch_sub(bytes); }
  std::uint64_t max_bytes() const { return max_bytes_; }
  std::uint64_t used() const { return used_.load(); }

 private:
  const std::uint64_t max_bytes_;
  std::atomic<std::uint64_t> used_{0};
};

class Upload {
 public:
  using Refusal = std::optional<api::Problem>;

  // Borrows the budget; the destructor gives back what append() took. `temp_dir`: directory of the temporary file.
  Upload(ByteBudget& budget, std::string temp_dir) : budget_(budget), temp_dir_(std::move(temp_dir)) {}
  ~Upload();
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  // Appends to the upload. Returns a problem if the budget is exhausted or the file cannot be written.
  Refusal append(std::string_view piece);
  // Ends the upload: bytes() and file() are valid afterwards. `with_file` false: file() stays -1, which saves a
  // descriptor. Returns a problem if the file cannot be mapped.
  Refusal finish(bool with_file = true);
  std::span<const std::byte> bytes() const { return bytes_; }
  std::uint64_t size() const { return size_; }
  int file() const { return read_only_.get(); }  // read-only descriptor of the same bytes; -1: in memory only

 private:
  Refusal spill(std::string_view piece);
  void close_file();

  ByteBudget& budget_;
  std::string temp_dir_;
  std::vector<std::byte> memory_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::span<const std::byte> bytes_;
  bool mapped_ = false;
  Descriptor read_only_;
};

// Opens a new file in `directory` that has no name and is removed with its last descriptor. Returns the descriptor; -1:
// failed, see errno.
int open_unnamed_file(const std::string& directory);

}  // namespace meshgauge::server
