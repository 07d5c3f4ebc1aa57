// A BlobStore of blobs that are kept elsewhere: the remote store decides what there is, the cache gives the bytes.
//
// open() of a blob that this machine has in its cache asks nobody, so it goes on working while the remote store does
// not answer; and it may give one that another process has removed. Whether somebody may have a blob is not for the
// bytes to decide: jobs and meshes are asked for that.
#pragma once

#include <memory>
#include <string>

#include "server/store/blob_cache.h"
#include "server/store/blob_store.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

class CachedBlobs final : public BlobStore {
 public:
  // Where several processes share the remote store, so must the reservations be shared: see blob_store.h.
  CachedBlobs(std::unique_ptr<RemoteBlobs> remote, std::unique_ptr<BlobCache> cache,
              std::unique_ptr<Reservations> reservations = std::make_unique<Reservations>())
      : BlobStore(std::move(reservations)), remote_(std::move(remote)), cache_(std::move(cache)) {}

  Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) override;
  Result<BlobPut> put(const BlobKey& key, int file, std::uint64_t size) override;
  Result<std::optional<Blob>> open(const BlobKey& key) override;
  Result<bool> exists(const BlobKey& key) override;
  Result<bool> renew(const BlobKey& key) override;
  Result<bool> remove(const BlobKey& key) override;
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
