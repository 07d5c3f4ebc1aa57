// The bytes of meshes in the store: quotas, and removal when nothing refers to them any more.
#pragma once

#include <deque>
#include <mutex>
#include <string>
#include <variant>

#include "server/access/access.h"
#include "server/measure/stores.h"

namespace meshgauge::server {

// What a stored mesh takes beside its bytes: the rest of its last block on the disk, and its row.
inline constexpr std::uint64_t kMeshOverhead = 5 << 10;

// What counts against an owner's quota: its meshes and the files of its unended comparisons, with the overhead.
Result<std::uint64_t> bytes_of(const Stores& stores, const std::string& owner);

// Reserves quota for bytes that are about to be put, on top of bytes_of() the owner
// (Access::hold_storage()). Add kMeshOverhead for a new mesh.
// Each caller holds the bytes of a new blob until it is put, so an owner's blobs never pass the limit together. For 0
// bytes it holds and denies nothing.
std::variant<StorageHold, Denial> hold_storage(Access& access, const Stores& stores, const std::string& owner,
                                               std::uint64_t bytes, std::uint64_t max_stored_bytes);

// Removes the blob now, not at the next sweep. false: it is used or reserved, or does not exist.
Result<bool> remove_if_unreferenced(const Stores& stores, const store::BlobKey& key);

// Removes the two meshes of an ended comparison if nothing else refers to them. Does nothing in shared stores, where
// the check costs several round trips: there UnneededBlobs of the front end that received a mesh removes it, or a
// sweep.
void release_blobs(const Stores& stores, StoreErrors& store_errors, const std::string& owner, const std::string& a,
                   const std::string& b);

// A queue of blobs to remove unless something refers to them. Thread safe.
class UnneededBlobs {
 public:
  UnneededBlobs(const Stores& stores, StoreErrors& store_errors) : stores_(stores), store_errors_(store_errors) {}

  void add(store::BlobKey key);
  void remove_some();  // blocks for about a second at most

 private:
  const Stores stores_;
  StoreErrors& store_errors_;
  std::mutex mutex_;  // guards what follows
  std::deque<store::BlobKey> keys_;
};

}  // namespace meshgauge::server
