#include "server/store/reserve.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "server/store/data_folder.h"

namespace meshgauge::server::store {

std::uint64_t reserve_bytes(std::uint64_t disk_bytes) {
  return std::clamp(disk_bytes / 64, std::uint64_t{1} << 20, std::uint64_t{32} << 20);
}

// Takes what there is when it is not enough: else others would.
bool Reserve::restore() {
  if (whole_.load()) return true;
  const std::lock_guard lock(mutex_);
  const Descriptor file = open_file(path_, O_RDWR | O_CREAT);
  struct statvfs disk {};
  if (!file || ::fstatvfs(file.get(), &disk) != 0) return false;
  const std::uint64_t bytes = reserve_bytes(std::uint64_t{disk.f_blocks} * disk.f_frsize);
  const auto allocate = [&](std::uint64_t eighths) {
    return ::posix_fallocate(file.get(), 0, static_cast<off_t>(bytes / 8 * eighths));
  };
  const int failure = allocate(8);
  for (std::uint64_t eighths = 7; failure != 0 && eighths > 0 && allocate(eighths) != 0; --eighths) {
  }
  whole_ = failure == 0;
  errno = failure;
  return whole_;
}

void Reserve::release() {
  const std::lock_guard lock(mutex_);
  whole_ = false;
  [[maybe_unused]] const int cut = ::truncate(path_.c_str(), 0);  // if it fails, the removal fails as well
}

Error Reserve::not_restored(const std::string& what) { return storage_error(errno, what); }

}  // namespace meshgauge::server::store
