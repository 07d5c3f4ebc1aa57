// The bytes of one uploaded file: up to 256 KiB in memory, more in an unnamed temporary file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/base/descriptor.h"
#include "api/base/problem.h"

namespace meshgauge::server {

// Limits the bytes that all uploads hold together, and each client's share of them (share.h). Thread safe.
class ByteBudget {
 public:
  explicit ByteBudget(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // False: the limit or the client's share would be exceeded; nothing is taken.
  bool take(std::uint64_t bytes, const std::string& client);
  void give(std::uint64_t bytes, const std::string& client);
  std::uint64_t max_bytes() const { return max_bytes_; }
  std::uint64_t used() const;

 private:
  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;  // guards what follows
  std::uint64_t used_ = 0;
  std::map<std::string, std::uint64_t> used_by_;  // no zeros
};

// The budget as one client sees it; borrowed.
struct UploadShare {
  // NOLINTNEXTLINE(google-explicit-constructor): a budget is the share of the only client
  UploadShare(ByteBudget& all, std::string name = "") : budget(&all), client(std::move(name)) {}

  ByteBudget* budget;
  std::string client;
};

class Upload {
 public:
  using Refusal = std::optional<api::Problem>;

  // Borrows the budget; the destructor gives back what append() took. `temp_dir`: directory of the temporary file.
  Upload(UploadShare share, std::string temp_dir) : share_(std::move(share)), temp_dir_(std::move(temp_dir)) {}
  ~Upload();
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  // Appends to the upload. Returns a problem if the budget is exhausted or the file cannot be written.
  Refusal append(std::string_view piece);
  // Ends the upload: bytes() and file() are valid afterwards. `with_file` false: file() stays -1, which saves a
  // descriptor. Returns a problem if the file cannot be mapped.
  Refusal finish(bool with_file = true);
  std::span<const std::byte> bytes() const { return bytes_; }
  std::string_view text() const { return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}; }
  std::uint64_t size() const { return size_; }
  int file() const { return read_only_.get(); }  // read-only descriptor of the same bytes; -1: in memory only

 private:
  Refusal spill(std::string_view piece);
  void close_file();

  const UploadShare share_;
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
