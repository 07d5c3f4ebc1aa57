// The bytes of meshes in the store: room for them, and their end when nothing refers to them any more.
#pragma once

#include <deque>
#include <mutex>
#include <string>
#include <variant>

#include "server/access/access.h"
#include "server/jobs/store_errors.h"
#include "server/jobs/stores.h"

namespace meshgauge::server {

// Access::hold_storage() beside what the owner's blobs take when it asks. Whoever puts a blob that is not there holds
// its bytes until the blob is put: so all of an owner's together never pass the limit. Nothing is held, or denied, for
// 0.
std::variant<StorageHold, Denial> hold_storage(Access& access, store::BlobStore& blobs, const std::string& owner,
                                               std::uint64_t bytes, std::uint64_t max_stored_bytes);

// At once, so that nobody's deleted bytes fill the disk until the next sweep.
Result<bool> remove_if_unreferenced(const Stores& stores, const store::BlobKey& key);

// What a comparison of this owner does not refer to any more. Nothing in shared stores, where each look is several
// messages to others: UnneededBlobs of the front end that was sent a mesh with a comparison removes it, or a sweep.
void release_blobs(const Stores& stores, StoreErrors& store_errors, const std::string& owner, const std::string& a,
                   const std::string& b);

// Blobs to be removed soon, unless something else refers to them. Thread safe.
class UnneededBlobs {
 public:
  UnneededBlobs(const Stores& stores, StoreErrors& store_errors) : stores_(stores), store_errors_(store_errors) {}

  void add(store::BlobKey key);
  void remove_some();  // for about a second: its caller has other upkeep to do

 private:
  const Stores stores_;
  StoreErrors& store_errors_;
  std::mutex mutex_;  // guards what follows
  std::deque<store::BlobKey> keys_;
};

}  // namespace meshgauge::server
