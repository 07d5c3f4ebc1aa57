// Free room on a disk that caches must leave for uploads and results.
#pragma once

#include <cstdint>
#include <string>

namespace meshgauge::server {

// Size and free bytes of a disk.
struct DiskRoom {
  std::uint64_t bytes = 0;
  std::uint64_t free = 0;
};

// Returns the bytes that are missing until `wanted` bytes, or a sixty-fourth of the disk if that is less, are free.
std::uint64_t lacking_bytes(DiskRoom disk, std::uint64_t wanted);

// The same for the folder's disk; 0 if its size is unknown.
std::uint64_t lacking_bytes_on(const std::string& folder, std::uint64_t wanted);

}  // namespace meshgauge::server
