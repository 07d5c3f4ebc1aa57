// The folder that a service keeps its state in, for itself alone as long as this object lives.
//
//   lock         held by the process that uses the folder; its content is that process's number
//   jobs.sqlite  jobs, results, what is known about meshes (sqlite_store.h); with -wal and -shm beside it
//   blobs/       the bytes of meshes (file_blobs.h)
//   maps/        deviation maps, a cache (server/maps/map_cache.h)
#pragma once

#include <string>

#include "engine/result.h"
#include "server/sandbox/descriptor.h"

namespace meshgauge::server::store {

class DataFolder {
 public:
  // Makes the folder, for its owner alone, when there is none. Refuses one that cannot be written to or that another
  // process uses.
  static Result<DataFolder> open(const std::string& path);

  const std::string& path() const { return path_; }

 private:
  DataFolder(std::string path, Descriptor lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::string path_;
  Descriptor lock_;  // the kernel takes the lock back from a process that dies, however it dies
};

// Makes the entries of a folder (new, renamed and removed names) durable.
Result<Done> sync_folder(const std::string& path);

// false: it was there. Not yet durable: sync_folder() of the folder around it.
Result<bool> make_folder(const std::string& path);

}  // namespace meshgauge::server::store
