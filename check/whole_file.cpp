#include "check/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace meshgauge::check {
namespace {

Error refused(const std::string& path, const std::string& why) {
  return Error{ErrorCode::invalid_request, "'" + path + "' " + why, "", ""};
}

Error failed(const std::string& path) { return refused(path, std::string("cannot be read: ") + std::strerror(errno)); }

Result<std::span<const std::byte>> map(int fd, const std::string& path) {
  struct stat status {};
  if (fstat(fd, &status) != 0) return failed(path);
  if (!S_ISREG(status.st_mode)) return refused(path, "is not a regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return std::span<const std::byte>{};
  void* start = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
  if (start == MAP_FAILED) return failed(path);
  return std::span(static_cast<const std::byte*>(start), size);
}

}  // namespace

Result<MappedFile> MappedFile::open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe without a writer must not block
  if (fd < 0) return failed(path);
  auto bytes = map(fd, path);
  ::close(fd);
  if (!bytes) return bytes.error();
  return MappedFile(*bytes);
}

MappedFile::MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace meshgauge::check
