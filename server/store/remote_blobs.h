// A store of blobs that is not a disk of this machine: S3, or chunks in PostgreSQL. CachedBlobs makes a BlobStore of
// it, by files on this machine's disk.
//
// The contract is BlobStore's, without mapping: all calls are thread safe, also across processes; errors are
// storage_full, storage_unavailable and internal; no blob is visible half written, and a failed call may be repeated.
// Calls block for the network within time limits: an implementation repeats what may pass, then returns
// storage_unavailable.
//
// Precondition of every call: is_blob_id(key.id).
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

// "<SHA-256 of the owner>/<first two digits>/<id>": the name of a blob outside, without its owner's name.
std::string blob_name(const BlobKey& key);

class RemoteBlobs {
 public:
  // Takes the bytes of a blob, each once and in order. An error ends the fetch, which returns it.
  using Take = std::function<Result<Done>(std::span<const std::byte> piece)>;

  virtual ~RemoteBlobs() = default;

  // As BlobStore::put(): durable when it returns. Checks the digest of the bytes that are written. Renews a blob that
  // exists, and replaces it if it is damaged.
  virtual Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) = 0;

  // false: no such blob, and take() was not called. The caller checks digest and size; an implementation only returns
  // an error when it knows that bytes are missing.
  virtual Result<bool> fetch(const BlobKey& key, const Take& take) = 0;

  virtual Result<bool> exists(const BlobKey& key) = 0;
  virtual Result<bool> renew(const BlobKey& key) = 0;   // makes it as young as put() does; false: no such blob
  virtual Result<bool> remove(const BlobKey& key) = 0;  // used or not; false: no such blob
  // Counts what remove_unused() would remove.
  virtual Result<UnusedBlobs> count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) = 0;
  // Removes blobs that are not in `used` and were neither put nor renewed within `older_than`, by the store's own
  // clock. Returns their number. Each removal runs in reservations.unless_held() and checks the age again there,
  // unless removal and renewal cannot overlap (one transaction).
  virtual Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                              Reservations& reservations) = 0;

  // The bytes of all blobs of an owner, referred to or not. Cheap: called at each upload. May lag behind what other
  // processes have put, by a time that the implementation states, never behind what this object has put.
  virtual Result<std::uint64_t> stored_bytes(const std::string& owner) = 0;
  virtual Result<std::uint64_t> free_bytes() = 0;  // left for blobs; the largest number: unknown
  virtual Result<Done> check() = 0;                // writes something: can blobs be stored?
};

}  // namespace meshgauge::server::store
