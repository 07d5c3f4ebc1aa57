#include "check/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

namespace meshgauge::check {
namespace {

Error refused(const std::string& path, const std::string& why) {
  return Error{ErrorCode::invalid_request, "'" + path + "' " + why, "", ""};
}

Error failed(const std::string& path) { return refused(path, std::string("cannot be read: ") + std::strerror(errno)); }

class Opened {
 public:
  explicit Opened(const std::string& path)  // a pipe without a writer must not block
      : fd_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  ~Opened() {
    if (fd_ >= 0) ::close(fd_);
  }

  int fd() const { return fd_; }

  // As many bytes as there are, up to the size of `to`; -1 and errno when it fails.
  ssize_t read(std::span<std::byte> to) const {
    std::size_t done = 0;
    while (done < to.size()) {
      const ssize_t n = ::read(fd_, to.data() + done, to.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return -1;
      if (n == 0) break;
      done += static_cast<std::size_t>(n);
    }
    return static_cast<ssize_t>(done);
  }

 private:
  const int fd_;
};

}  // namespace

Result<WholeFile> WholeFile::open(const std::string& path) {
  const Opened file(path);
  struct stat status {};
  if (file.fd() < 0 || ::fstat(file.fd(), &status) != 0) return failed(path);
  if (!S_ISREG(status.st_mode)) return refused(path, "is not a regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  std::unique_ptr<std::byte[]> bytes(new (std::nothrow) std::byte[size + 1]);  // and one to see the end by
  if (!bytes) return Error{ErrorCode::too_large, "'" + path + "' is larger than the memory", "", ""};
  const ssize_t read = file.read({bytes.get(), size + 1});
  if (read < 0) return failed(path);
  if (static_cast<std::size_t>(read) != size) return refused(path, "was changed while it was read");
  return WholeFile(std::move(bytes), size);
}

}  // namespace meshgauge::check
