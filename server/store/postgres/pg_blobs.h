// Blobs in the database, for where there is no S3: each in chunks, which are written one by one before its row appears
// and so makes them a blob. Whatever is left of an upload that never became one, or of a blob that was removed, is
// taken away by remove_unused().
//
// Each chunk that is there is compared by its digest, in the database, before put() says that a blob existed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/store/byte_source.h"
#include "server/store/postgres/pool.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

class PgBlobs final : public RemoteBlobs {
 public:
  static constexpr std::size_t kChunk = std::size_t{1} << 20;  // bytes; all chunks but the last one's
  static constexpr std::chrono::hours kAbandoned{24};          // an upload that began longer ago goes on no more

  explicit PgBlobs(PgPool& pool) : pool_(pool) {}  // outlives this object

  Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) override;
  Result<BlobPut> put(const BlobKey& key, int file, std::uint64_t size) override;
  Result<bool> fetch(const BlobKey& key, const Take& take) override;
  Result<bool> exists(const BlobKey& key) override;
  Result<bool> renew(const BlobKey& key) override;
  Result<bool> remove(const BlobKey& key) override;
  // Leaves as well what meshes and jobs of the same database refer to by then: whatever was not known when `used` was
  // listed is looked at, and the age too, by the statement that removes a blob.
  Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                      const Guard& guard) override;
  Result<std::uint64_t> stored_bytes(const std::string& owner) override;  // never behind
  Result<std::uint64_t> free_bytes() override;                            // nobody knows
  Result<Done> check() override;

 private:
  Result<BlobPut> put(const BlobKey& key, const ByteSource& source);
  Result<std::vector<std::string>> digests(const BlobKey& key, const ByteSource& source, bool& right);
  Result<BlobPut> put_anew(const BlobKey& key, const ByteSource& source, const std::string& damaged);
  // nullopt: it was sent, but the database lost some of it.
  Result<std::optional<BlobPut>> put_once(const BlobKey& key, const ByteSource& source, const std::string& damaged);
  Result<std::string> send(const ByteSource& source, const std::string& upload);
  Result<bool> remove_if_old(const BlobKey& key, std::optional<std::chrono::seconds> older_than, const Guard& guard);
  Result<Done> remove_chunks(const std::string& upload);
  Result<Done> remove_garbage();

  PgPool& pool_;
};

}  // namespace meshgauge::server::store
