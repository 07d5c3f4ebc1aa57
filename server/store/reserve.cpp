#include "server/store/reserve.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "server/sandbox/descriptor.h"
#include "server/store/errors.h"

namespace meshgauge::server::store {

std::uint64_t reserve_bytes(std::uint64_t disk_bytes) {
  return std::clamp(disk_bytes / 64, std::uint64_t{1} << 20, std::uint64_t{32} << 20);
}

// Takes what there is when it is not enough: else others would.
bool Reserve::restore() {
  if (whole_.load()) return true;
  const std::lock_guard lock(mutex_);
  const Descriptor file(::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  struct statvfs disk {};
  if (!file || ::fstatvfs(file.get(), &disk) != 0) return false;
  const std::uint64_t bytes = reserve_bytes(std::uint64_t{disk.f_blocks} * disk.f_frsize);
  std::uint64_t eighths = 8;
  while (eighths > 0 && ::posix_fallocate(file.get(), 0, static_cast<off_t>(bytes / 8 * eighths)) != 0) --eighths;
  whole_ = eighths == 8;
  return whole_;
}

void Reserve::release() {
  const std::lock_guard lock(mutex_);
  whole_ = false;
  [[maybe_unused]] const int cut = ::truncate(path_.c_str(), 0);  // if it fails, the removal fails as well
}

Error Reserve::no_room(const std::string& what) { return storage_error(ENOSPC, what); }

}  // namespace meshgauge::server::store
