// A BlobStore over remote blobs: the remote store decides which blobs exist, the cache has their bytes.
//
// open() of a cached blob does not ask the remote store, so it works while that does not answer, and may return a blob
// that another process has removed. That is safe: rows of jobs and meshes decide which owner may read a blob.
#pragma once

#include <memory>
#include <string>

#include "server/store/blob_cache.h"
#include "server/store/blob_store.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

class CachedBlobs final : public BlobStore {
 public:
  // Processes that share the remote store must share the reservations: see blob_store.h.
  CachedBlobs(std::unique_ptr<RemoteBlobs> remote, std::unique_ptr<BlobCache> cache,
              std::unique_ptr<Reservations> reservations = std::make_unique<Reservations>())
      : BlobStore(std::move(reservations)), remote_(std::move(remote)), cache_(std::move(cache)) {}

  Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) override;
  Result<std::optional<Blob>> open(const BlobKey& key) override;
  Result<bool> exists(const BlobKey& key) override;
  Result<bool> renew(const BlobKey& key) override;
  Result<bool> remove(const BlobKey& key) override;
  Result<UnusedBlobs> count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) override {
    return remote_->count_unused(used, older_than);
  }
  Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) override;
  Result<std::uint64_t> stored_bytes(const std::string& owner) override;
  Result<std::uint64_t> free_bytes() override;
  Result<Done> check() override;

  const BlobCache& cache() const { return *cache_; }

 private:
  const std::unique_ptr<RemoteBlobs> remote_;
  const std::unique_ptr<BlobCache> cache_;
};

}  // namespace meshgauge::server::store
