// The bytes of one uploaded part: small ones in memory, larger ones in a file without a name.
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

// Bytes that all uploads together may hold. Thread safe.
class ByteBudget {
 public:
  explicit ByteBudget(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  bool take(std::uint64_t bytes);
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

  // `budget` must outlive the upload, which gives back what it took when it is destroyed.
  Upload(ByteBudget& budget, std::string temp_dir) : budget_(budget), temp_dir_(std::move(temp_dir)) {}
  ~Upload();
  Upload(const Upload&) = delete;
  Upload& operator=(const Upload&) = delete;

  Refusal append(std::string_view piece);
  // Makes bytes() available, and file() unless `with_file` is false: of many uploads each would hold a descriptor.
  Refusal finish(bool with_file = true);
  std::span<const std::byte> bytes() const { return bytes_; }
  std::uint64_t size() const { return size_; }
  int file() const { return read_only_.get(); }  // a descriptor of the same bytes; -1: they are in memory alone

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

// A file in `directory` that no name leads to and that is gone with its descriptor; -1 and errno when it fails.
int open_unnamed_file(const std::string& directory);

}  // namespace meshgauge::server
