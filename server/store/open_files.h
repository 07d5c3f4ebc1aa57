// Whether the files of an open SQLite database are still those that the next process opens by their paths.
//
// SQLite goes on reading and writing a file that was removed or replaced, and all of it is gone with the process.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "engine/result.h"

namespace meshgauge::server::store {

// Thread safe.
class OpenFiles {
 public:
  // Remembers the files of the database at `path`: itself, its log, and the log's index. Precondition: it is open, and
  // has been read, which makes the other two.
  explicit OpenFiles(const std::string& path);

  // An Error (storage_unavailable) if one of them was removed or replaced. It passes when they are put back. Cheap.
  Result<Done> check() const;

 private:
  struct File {
    std::string path;
    dev_t device;
    ino_t number;
  };
  std::vector<File> files_;
};

}  // namespace meshgauge::server::store
