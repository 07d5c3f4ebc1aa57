// Room on a disk that is left to what matters more than a cache.
#pragma once

#include <cstdint>
#include <string>

namespace meshgauge::server {

// The disk of a folder.
struct DiskRoom {
  std::uint64_t bytes = 0;  // of all of it
  std::uint64_t free = 0;
};

// What is missing for `wanted` bytes to be free, or for a sixty-fourth of the disk where that is less.
std::uint64_t lacking_bytes(DiskRoom disk, std::uint64_t wanted);

// The same of the disk that the folder is on; 0 where that cannot be told.
std::uint64_t lacking_bytes_on(const std::string& folder, std::uint64_t wanted);

}  // namespace meshgauge::server
