#include "api/base/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <climits>
#include <cstring>
#include <exception>
#include <fstream>
#include <limits>
#include <new>
#include <utility>

#include "api/base/descriptor.h"
#include "api/base/refused.h"

namespace meshgauge::api {
namespace {

Error unusable(const std::string& path, const std::string& why) { return refused("'" + path + "' " + why); }

Error failed(const std::string& path) { return unusable(path, std::string("cannot be read: ") + std::strerror(errno)); }

// Reads up to to.size() bytes and returns their number; -1 with errno: it failed.
ssize_t read_all(int fd, std::span<std::byte> to) {
  std::size_t done = 0;
  while (done < to.size()) {
    const ssize_t n = ::read(fd, to.data() + done, to.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return static_cast<ssize_t>(done);
}

// O_NONBLOCK: opening a pipe without a writer must not block.
constexpr int kToRead = O_RDONLY | O_CLOEXEC | O_NONBLOCK;
constexpr int kFolderToRead = O_RDONLY | O_DIRECTORY | O_CLOEXEC;

// Returns why a component could not be opened. A symbolic link is detected here, since the errno of openat() depends
// on its flags.
Error not_opened(const std::string& path, int folder, const std::string& component) {
  const int why = errno;
  struct stat status {};
  if (::fstatat(folder, component.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(status.st_mode)) {
    return unusable(path, "is a symbolic link or lies behind one, which is not followed: copy the file to that place");
  }
  errno = why;
  return failed(path);
}

// `flags`: of the last component.
Result<Descriptor> opened_below(const BaseFolder& folder, const std::string& name, int flags) {
  const std::string path = folder.path + "/" + name;
  if (name.size() >= PATH_MAX) return unusable(path, "cannot be read: its name is too long");
  Descriptor place(folder.held ? ::openat(folder.held->get(), ".", kFolderToRead)
                               : ::open(folder.path.c_str(), kFolderToRead));
  if (!place) return failed(folder.path);
  for (std::size_t at = 0, end = name.empty() ? std::string::npos : 0; end != std::string::npos; at = end + 1) {
    end = name.find('/', at);
    const std::string component = name.substr(at, end - at);
    assert(!component.empty());
    if (component == "..") return unusable(path, "has '..', which may lead out of the folder");
    const int how = end == std::string::npos ? flags : kFolderToRead;
    Descriptor opened(::openat(place.get(), component.c_str(), how | O_NOFOLLOW));
    if (!opened) return not_opened(path, place.get(), component);
    place = std::move(opened);
  }
  return Result<Descriptor>(std::move(place));
}

Result<Done> check_regular(int fd, const std::string& path, struct stat& status) {
  if (::fstat(fd, &status) != 0) return failed(path);
  if (S_ISDIR(status.st_mode)) return unusable(path, "is a folder: name a file in it");
  if (!S_ISREG(status.st_mode)) return unusable(path, "is not a regular file");
  return Done{};
}

}  // namespace

Result<Descriptor> open_folder_below(const BaseFolder& folder, const std::string& name) {
  return opened_below(folder, name, kFolderToRead);
}

Result<WholeFile> WholeFile::open(const std::string& path) {
  const Descriptor file(::open(path.c_str(), kToRead));
  return file ? read(file.get(), path, std::numeric_limits<std::uint64_t>::max()) : failed(path);
}

Result<WholeFile> WholeFile::open_below(const BaseFolder& folder, const std::string& name, std::uint64_t most) {
  const auto file = opened_below(folder, name, kToRead);
  return file ? read(file->get(), folder.path + "/" + name, most) : file.error();
}

Result<std::uint64_t> WholeFile::size_below(const BaseFolder& folder, const std::string& name) {
  const auto file = opened_below(folder, name, kToRead);
  if (!file) return file.error();
  struct stat status {};
  if (auto ok = check_regular(file->get(), folder.path + "/" + name, status); !ok) return ok.error();
  return static_cast<std::uint64_t>(status.st_size);
}

Result<WholeFile> WholeFile::read(int fd, const std::string& path, std::uint64_t most) {
  struct stat status {};
  if (auto ok = check_regular(fd, path, status); !ok) return ok.error();
  const auto there = static_cast<std::uint64_t>(status.st_size);
  if (there > most) {
    return Error{ErrorCode::too_large,
                 "'" + path + "' is larger than the " + std::to_string(most) + " bytes that may still be read", "", ""};
  }
  LargeArray<std::byte> bytes;
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(there, bytes.max_size() - 1));
  try {
    bytes.resize(size + 1);  // one byte more, to detect a file that grows
  } catch (const std::exception&) {
    return Error{ErrorCode::too_large, "'" + path + "' is larger than the memory", "", ""};
  }
  const ssize_t count = read_all(fd, bytes);
  if (count < 0) return failed(path);
  if (static_cast<std::uint64_t>(count) != there) return unusable(path, "was changed while it was read");
  bytes.resize(size);
  return WholeFile(std::move(bytes));
}

Result<std::string> read_text_file(const std::string& file, std::size_t max_bytes) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refused(std::string("cannot be read: ") + std::strerror(errno));
  // Reads one byte more than the limit to detect a larger file; a device without end then ends as well.
  std::string text(max_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return refused("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > max_bytes) return refused("larger than " + std::to_string(max_bytes) + " bytes");
  return text;
}

}  // namespace meshgauge::api
