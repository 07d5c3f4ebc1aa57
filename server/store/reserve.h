// Room on the disk of a data folder that only removals use. A database needs pages to delete rows, so a full disk would
// stay full. A preallocated file takes the room; it is given back to the file system for a removal, and made again
// after it. While it is not whole the disk counts as full. Thread safe.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>

#include "engine/result.h"

namespace meshgauge::server::store {

class Reserve {
 public:
  explicit Reserve(std::string path) : path_(std::move(path)) {}

  // Makes the file as large as it should be. false: it cannot, as when the disk has no room; errno says why. Cheap
  // while it is whole.
  bool restore();
  void release();  // gives its room to the file system, until restore()

  // The error of a write after restore() has failed, by errno; its message begins with `what`.
  static Error not_restored(const std::string& what);

 private:
  const std::string path_;
  std::mutex mutex_;
  std::atomic<bool> whole_{false};
};

// A 64th of a disk, at least 1 MiB and at most 32 MiB.
std::uint64_t reserve_bytes(std::uint64_t disk_bytes);

}  // namespace meshgauge::server::store
