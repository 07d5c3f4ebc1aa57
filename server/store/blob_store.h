// Bytes named by their SHA-256, apart for each owner: no owner shares, sees or is sped up by another one's.
//
// Every call is thread safe. Errors as in job_store.h: storage_full, storage_unavailable, internal; after an error
// nothing half-written is ever seen.
//
// remove_unused() may run at any time beside the others: put() and renew() keep a blob for `older_than` from then on,
// so whoever is about to refer to a blob (a job, a mesh) calls one of them before it stores the reference.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "engine/result.h"
#include "server/sandbox/descriptor.h"

namespace meshgauge::server::store {

struct BlobKey {
  std::string owner;
  std::string id;  // SHA-256 of the bytes, 64 lower-case hex digits; anything else names no blob
  bool operator==(const BlobKey&) const = default;
};

// Bytes that stay readable, whatever happens to the blob.
class Blob {
 public:
  Blob(Descriptor file, std::span<const std::byte> mapped) : file_(std::move(file)), bytes_(mapped) {}
  Blob(Blob&& other) noexcept : file_(std::move(other.file_)), bytes_(std::exchange(other.bytes_, {})) {}
  Blob& operator=(Blob&&) = delete;
  ~Blob();

  std::uint64_t size() const { return bytes_.size(); }
  std::span<const std::byte> bytes() const { return bytes_; }
  int file() const { return file_.get(); }  // a read-only descriptor of the same bytes

 private:
  Descriptor file_;
  std::span<const std::byte> bytes_;  // mapped, ours
};

enum class BlobPut {
  created,
  existed,
  other_digest,  // the bytes are not those that the id names: nothing is stored
};

class BlobStore {
 public:
  virtual ~BlobStore() = default;

  // Durable when it returns. The digest is checked on the bytes that are written. Keeps no reference to the bytes.
  virtual Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) = 0;
  // The same of the first `size` bytes of a file, read by offset: its own position is neither used nor moved.
  virtual Result<BlobPut> put(const BlobKey& key, int file, std::uint64_t size) = 0;

  virtual Result<std::optional<Blob>> open(const BlobKey& key) = 0;  // nullopt: there is none
  virtual Result<bool> exists(const BlobKey& key) = 0;
  virtual Result<bool> renew(const BlobKey& key) = 0;   // as put() of the same bytes; false: there is none
  virtual Result<bool> remove(const BlobKey& key) = 0;  // at once, used or not; false: there was none
  // Removes what is not in `used` and was neither put nor renewed within `older_than`; how many.
  virtual Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) = 0;

  virtual Result<std::uint64_t> free_bytes() = 0;  // that are left for blobs
  virtual Result<Done> check() = 0;                // that something can be stored, by storing it
};

}  // namespace meshgauge::server::store
