// The folder of a service's state: its lock against other processes, the rights of what is made in it, and the failures
// of its disk as Error.
//
//   lock         locked by the process that uses the folder; contains its process number
//   jobs.sqlite  jobs, results, rows of meshes (sqlite_store.h); with -wal and -shm beside it
//   blobs/       the bytes of meshes (file_blobs.h)
//   maps/        deviation maps, a cache (server/measure/map_cache.h)
//   reserve      room on the disk for removals (reserve.h)
//
// Rights of the files and folders that the service makes in it: their owner's alone, or also those of the folder's
// group where the folder says so. A container's volume does: the next process may run as another user, of the same
// group.
#pragma once

#include <string>

#include "api/base/descriptor.h"
#include "engine/result.h"

namespace meshgauge::server::store {

// Locks the folder while this object lives.
class DataFolder {
 public:
  // Creates the folder if needed, as make_folder() does. Error: it cannot be written to, or another process uses it.
  static Result<DataFolder> open(const std::string& path);

  const std::string& path() const { return path_; }

 private:
  DataFolder(std::string path, Descriptor lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::string path_;
  Descriptor lock_;  // the kernel frees the lock when the process dies
};

// Files that are being written, below a folder of blobs: what lies there at a start was never finished.
inline constexpr const char* kIncoming = "/incoming";

// Makes the entries of a folder (new, renamed and removed names) durable.
Result<Done> sync_folder(const std::string& path);

// Makes a folder with mode 0700; within a shared folder 0770, and shared as well. false: it existed. Not durable before
// sync_folder() of its parent. A folder is shared if its group may do all that its owner may, and either it is of group
// 0, which all processes of a container have, and others may not write; or new files get its group (setgid), and others
// have no rights at all.
Result<bool> make_folder(const std::string& path);

// As open() with O_CLOEXEC. A file that it makes has mode 0600; within a shared folder 0660, whatever the umask is.
// Where it may make a file in a shared folder, it follows no link at `path`: ELOOP.
Descriptor open_file(const std::string& path, int flags);

// As storage_error() for what cannot be done with `path`. If permission was denied, it also says which user the process
// runs as, which user and mode the path (or the first folder above that can be seen) has, and what to do.
Error access_error(int error_number, const std::string& what, const std::string& path);

// "<what>: No space left on device", with storage_full or storage_unavailable.
Error storage_error(int error_number, const std::string& what);

bool means_full(int error_number);  // the disk, the user's quota or the limit on file size

}  // namespace meshgauge::server::store
