// The bytes of a blob that is sent to another machine: in memory, or a file that is read by offset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "api/digest.h"
#include "engine/result.h"

namespace meshgauge::server::store {

// Borrows the bytes or the descriptor.
class ByteSource {
 public:
  ByteSource() = default;
  explicit ByteSource(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
  ByteSource(int file, std::uint64_t size) : file_(file), size_(size) {}

  std::uint64_t size() const { return size_; }
  ByteSource part(std::uint64_t offset, std::uint64_t size) const;  // precondition: offset + size <= size()

  // Copies bytes from the offset on to `into`; returns their number. Errors: those of a disk; internal when the file is
  // shorter than its size.
  Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> into) const;

  // The digest of all bytes. Also adds them to `whole`.
  Result<std::string> sha256_hex(api::Sha256* whole = nullptr) const;

 private:
  std::span<const std::byte> bytes_;
  int file_ = -1;
  std::uint64_t begin_ = 0;  // in the file
  std::uint64_t size_ = 0;
};

}  // namespace meshgauge::server::store
