// Reads the bytes of a meshopt stream in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace meshgauge::api {

class MeshoptBytes {
 public:
  explicit MeshoptBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}

  // Returns the next `count` bytes, valid as long as the stream. nullptr: fewer are left.
  const std::byte* take(std::size_t count) {
    if (count > bytes_.size() - at_) return nullptr;
    const std::byte* taken = bytes_.data() + at_;
    at_ += count;
    return taken;
  }

  bool take_byte(std::uint8_t& out) {
    const std::byte* taken = take(1);
    if (taken != nullptr) out = static_cast<std::uint8_t>(*taken);
    return taken != nullptr;
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

}  // namespace meshgauge::api
