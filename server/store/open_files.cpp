#include "server/store/open_files.h"

#include <sys/stat.h>

namespace meshgauge::server::store {

OpenFiles::OpenFiles(const std::string& path) {
  for (const char* const end : {"", "-wal", "-shm"}) {
    struct stat status {};
    const std::string file = path + end;
    if (::stat(file.c_str(), &status) == 0) files_.push_back({file, status.st_dev, status.st_ino});
  }
}

Result<Done> OpenFiles::check() const {
  for (const File& file : files_) {
    struct stat status {};
    const bool there = ::stat(file.path.c_str(), &status) == 0;
    if (there && status.st_dev == file.device && status.st_ino == file.number) continue;
    return Error{ErrorCode::storage_unavailable,
                 std::string("the database's files were ") + (there ? "replaced" : "removed") +
                     " while the service runs: put them back, or restart it",
                 "", ""};
  }
  return Done{};
}

}  // namespace meshgauge::server::store
