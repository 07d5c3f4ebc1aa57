#include "server/store/cached_blobs.h"

namespace meshgauge::server::store {

Result<BlobPut> CachedBlobs::put(const BlobKey& key, std::span<const std::byte> bytes) {
  if (!is_blob_id(key.id)) return BlobPut::other_digest;
  return remote_->put(key, bytes);
}

Result<std::optional<Blob>> CachedBlobs::open(const BlobKey& key) {
  if (!is_blob_id(key.id)) return std::optional<Blob>();
  return cache_->get(key, [&](const RemoteBlobs::Take& take) { return remote_->fetch(key, take); });
}

Result<bool> CachedBlobs::exists(const BlobKey& key) {
  if (!is_blob_id(key.id)) return false;
  return remote_->exists(key);
}

Result<bool> CachedBlobs::renew(const BlobKey& key) {
  if (!is_blob_id(key.id)) return false;
  return remote_->renew(key);
}

Result<bool> CachedBlobs::remove(const BlobKey& key) {
  if (!is_blob_id(key.id)) return false;
  Result<bool> removed = remote_->remove(key);
  if (removed) cache_->forget(key);
  return removed;
}

// The cached files of removed blobs age out of the cache like any unused file.
Result<std::uint64_t> CachedBlobs::remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) {
  return remote_->remove_unused(used, older_than,
                                [this](const std::string& name, const std::function<Result<bool>()>& removal) {
                                  return reservations().unless_held(name, removal);
                                });
}

Result<std::uint64_t> CachedBlobs::stored_bytes(const std::string& owner) { return remote_->stored_bytes(owner); }

Result<std::uint64_t> CachedBlobs::free_bytes() { return remote_->free_bytes(); }

Result<Done> CachedBlobs::check() { return remote_->check(); }

}  // namespace meshgauge::server::store
