#include "server/maps/spare_room.h"

#include <sys/statvfs.h>

#include <algorithm>

namespace meshgauge::server {
namespace {

constexpr std::uint64_t kShare = 64;  // of a small disk only this fraction is kept free

}  // namespace

std::uint64_t lacking_bytes(DiskRoom disk, std::uint64_t wanted) {
  const std::uint64_t least = std::min(wanted, disk.bytes / kShare);
  return least - std::min(disk.free, least);
}

std::uint64_t lacking_bytes_on(const std::string& folder, std::uint64_t wanted) {
  struct statvfs status {};
  if (::statvfs(folder.c_str(), &status) != 0) return 0;
  const std::uint64_t block = status.f_frsize;
  return lacking_bytes({std::uint64_t{status.f_blocks} * block, std::uint64_t{status.f_bavail} * block}, wanted);
}

}  // namespace meshgauge::server
