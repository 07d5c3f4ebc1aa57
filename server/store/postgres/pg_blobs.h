// Blobs in the database, for installations without S3. Chunks are written one by one; the row that is inserted last
// makes them a blob. remove_unused() removes chunks of unfinished uploads and of removed blobs.
//
// put() compares each stored chunk by its digest, in the database, before it returns `existed`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/store/postgres/pool.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

class PgBlobs final : public RemoteBlobs {
 public:
  static constexpr std::size_t kChunk = std::size_t{1} << 20;  // bytes of a chunk; the last one may be smaller
  static constexpr std::chrono::hours kAbandoned{24};          // an upload that began longer ago is given up

  explicit PgBlobs(PgPool& pool) : pool_(pool) {}  // borrows the pool

  Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) override;
  Result<bool> fetch(const BlobKey& key, const Take& take) override;
  Result<bool> exists(const BlobKey& key) override;
  Result<bool> renew(const BlobKey& key) override;
  Result<bool> remove(const BlobKey& key) override;
  // Also keeps blobs that meshes and jobs of the same database have come to refer to since `used` was listed: the
  // statement that removes a blob checks that, and the age.
  Result<UnusedBlobs> count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) override {
    const auto found = unused(used, older_than);
    if (!found) return found.error();
    return UnusedBlobs{found->size()};  // none is older than the database, which is the jobs' as well
  }
  Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                      Reservations& reservations) override;
  Result<std::uint64_t> stored_bytes(const std::string& owner) override;  // exact
  Result<std::uint64_t> free_bytes() override;                            // unknown
  Result<Done> check() override;

 private:
  Result<std::vector<BlobKey>> unused(std::span<const BlobKey> used, std::chrono::seconds older_than);
  Result<BlobPut> put_anew(const BlobKey& key, std::span<const std::byte> bytes, const std::string& damaged);
  // nullopt: the database lost some of what was sent.
  Result<std::optional<BlobPut>> put_once(const BlobKey& key, std::span<const std::byte> bytes,
                                          const std::string& damaged);
  Result<Done> send(std::span<const std::byte> bytes, const std::string& upload);
  Result<bool> remove_if_old(const BlobKey& key, std::chrono::seconds older_than, Reservations& reservations);
  Result<Done> remove_chunks(const std::string& upload);
  Result<Done> remove_garbage();

  PgPool& pool_;
};

}  // namespace meshgauge::server::store
