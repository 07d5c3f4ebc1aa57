// The folder of a service's state, locked against other processes while this object lives.
//
//   lock         locked by the process that uses the folder; contains its process number
//   jobs.sqlite  jobs, results, rows of meshes (sqlite_store.h); with -wal and -shm beside it
//   blobs/       the bytes of meshes (file_blobs.h)
//   maps/        deviation maps, a cache (server/measure/map_cache.h)
//   reserve      room on the disk for removals (reserve.h)
#pragma once

#include <string>

#include "api/descriptor.h"
#include "engine/result.h"

namespace meshgauge::server::store {

class DataFolder {
 public:
  // Creates the folder if needed (rights.h). Error: it cannot be written to, or another process uses it.
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

}  // namespace meshgauge::server::store
