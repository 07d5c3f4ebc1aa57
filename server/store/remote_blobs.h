// Where blobs are kept when that is not a disk of this machine (S3, chunks in PostgreSQL): what CachedBlobs
// (blob_cache.h) makes a BlobStore of, by files on this machine's disk.
//
// The contract is BlobStore's, except that nothing can be mapped: every call is thread safe and may come from many
// processes at once; errors are storage_full, storage_unavailable, internal; after an error nothing half-written is
// ever seen, and the call may be repeated. Calls wait for the network, but not for ever: whoever implements this has
// time limits, repeats what may pass by itself, and then says storage_unavailable.
//
// CachedBlobs asks only for keys with is_blob_id(key.id).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "engine/result.h"
#include "server/store/blob_store.h"

namespace meshgauge::server::store {

bool is_blob_id(const std::string& id);  // 64 lower-case hex digits

// "<SHA-256 of the owner>/<first two digits>/<id>": what a blob is called outside, where no owner's name may appear.
std::string blob_name(const BlobKey& key);

class RemoteBlobs {
 public:
  // Is given the bytes of a blob from its begin, each once. An error ends the fetch, which returns it.
  using Take = std::function<Result<Done>(std::span<const std::byte> piece)>;
  // Calls removal(), during which nobody begins to refer to the blob of this name (blob_name()); or does not, because
  // somebody is about to, and says false.
  using Guard = std::function<Result<bool>(const std::string& name, const std::function<Result<bool>()>& removal)>;

  virtual ~RemoteBlobs() = default;

  // As BlobStore::put(): durable when they return; the digest is checked on the bytes that are written; what is there
  // already is renewed, and replaced if it was damaged.
  virtual Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) = 0;
  virtual Result<BlobPut> put(const BlobKey& key, int file, std::uint64_t size) = 0;  // by pread() from offset 0

  // false: there is none, and take() was not called. The caller checks the digest and the end: an implementation need
  // not, but says an error when it knows that bytes are missing.
  virtual Result<bool> fetch(const BlobKey& key, const Take& take) = 0;

  virtual Result<bool> exists(const BlobKey& key) = 0;
  virtual Result<bool> renew(const BlobKey& key) = 0;   // as put() of the same bytes; false: there is none
  virtual Result<bool> remove(const BlobKey& key) = 0;  // at once, used or not; false: there was none
  // Removes what is not in `used` and was neither put nor renewed within `older_than`, by the store's own clock; how
  // many. Where a blob's removal and its renewal by another process could cross, each removal goes through `guard`
  // and looks at the age again inside; where they cannot (one transaction), it need not be called.
  virtual Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                              const Guard& guard) = 0;

  // What an owner's blobs take, referred to or not. Cheap: asked at each upload. It may be behind what other
  // processes have put, by a time that the implementation states, never behind what this object has.
  virtual Result<std::uint64_t> stored_bytes(const std::string& owner) = 0;
  virtual Result<std::uint64_t> free_bytes() = 0;  // that are left for blobs; the largest number: nobody knows a limit
  virtual Result<Done> check() = 0;                // that something can be stored, by storing it
};

}  // namespace meshgauge::server::store
