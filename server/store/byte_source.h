// Where the bytes of a blob come from that is sent elsewhere: memory, or a file that is read by offset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "api/digest.h"
#include "engine/result.h"

namespace meshgauge::server::store {

// Refers to the bytes or the descriptor, which outlive it.
class ByteSource {
 public:
  ByteSource() = default;
  explicit ByteSource(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
  ByteSource(int file, std::uint64_t size) : file_(file), size_(size) {}

  std::uint64_t size() const { return size_; }
  ByteSource part(std::uint64_t offset, std::uint64_t size) const;  // offset + size <= size()

  // Fills `into` from the offset on, as far as there are bytes; how many. Errors: as of a disk, and internal when the
  // file is shorter than its size.
  Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> into) const;

  // All of it, also to a digest that goes on.
  Result<std::string> sha256_hex(api::Sha256* whole = nullptr) const;

 private:
  std::span<const std::byte> bytes_;
  int file_ = -1;
  std::uint64_t begin_ = 0;  // in the file
  std::uint64_t size_ = 0;
};

}  // namespace meshgauge::server::store
