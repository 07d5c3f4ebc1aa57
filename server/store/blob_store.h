// Bytes named by their SHA-256, apart for each owner: no owner shares, sees or is sped up by another one's.
//
// Every call is thread safe. Errors as in job_store.h: storage_full, storage_unavailable, internal; after an error
// nothing half-written is ever seen.
//
// Whoever is about to refer to a blob (a job, a mesh) reserves it, calls put() or renew(), and stores the reference:
// until the reservation goes, remove_unreferenced() leaves the blob. remove_unused() may run at any time beside the
// others, and in another process: put() and renew() keep a blob from it for `older_than`.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
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

  static Result<Blob> map(Descriptor file);  // all of a file that nobody writes to any more

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

// Who is about to refer to which blob. This one is for the stores of one process; where several processes share their
// blobs, one that they share has to take its place: then begin(), end() and unless_held() are its own. Thread safe.
class Reservations {
 public:
  // Of one blob, for one who is about to refer to it.
  class Held {
   public:
    Held(Reservations& all, const BlobKey& key);
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;
    ~Held();

   private:
    Reservations& all_;
    const std::string name_;
  };

  Reservations() = default;
  Reservations(const Reservations&) = delete;
  Reservations& operator=(const Reservations&) = delete;
  virtual ~Reservations() = default;

  // Calls work(), and lets no reservation of this blob (by its blob_name()) begin meanwhile, unless there is one: then
  // it is false.
  virtual Result<bool> unless_held(const std::string& name, const std::function<Result<bool>()>& work);

 protected:
  virtual void begin(const std::string& name);  // waits for work() of the same name
  virtual void end(const std::string& name);    // once for each begin()

 private:
  std::mutex mutex_;
  std::condition_variable done_;
  std::multiset<std::string> held_;
  std::set<std::string> closed_;  // those that work() is called for
};

class BlobStore {
 public:
  BlobStore() : BlobStore(std::make_unique<Reservations>()) {}
  explicit BlobStore(std::unique_ptr<Reservations> reservations) : reservations_(std::move(reservations)) {}
  BlobStore(const BlobStore&) = delete;
  BlobStore& operator=(const BlobStore&) = delete;
  virtual ~BlobStore() = default;

  Reservations::Held reserve(const BlobKey& key) { return {*reservations_, key}; }

  // Durable when it returns. The digest is checked on the bytes that are written; a blob that is there already is read
  // again, and replaced if it was damaged. Keeps no reference to the bytes.
  virtual Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) = 0;
  // The same of the first `size` bytes of a file, read by offset: its own position is neither used nor moved.
  virtual Result<BlobPut> put(const BlobKey& key, int file, std::uint64_t size) = 0;

  virtual Result<std::optional<Blob>> open(const BlobKey& key) = 0;  // nullopt: there is none
  virtual Result<bool> exists(const BlobKey& key) = 0;
  virtual Result<bool> renew(const BlobKey& key) = 0;   // as put() of the same bytes; false: there is none
  virtual Result<bool> remove(const BlobKey& key) = 0;  // at once, used or not; false: there was none
  // At once, unless it is reserved or `referenced` says that something refers to it; false: it stays, or there was
  // none.
  Result<bool> remove_unreferenced(const BlobKey& key, const std::function<Result<bool>()>& referenced);
  // Removes what is not in `used` and was neither put nor renewed within `older_than`; how many.
  virtual Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) = 0;

  // What an owner's blobs take, referred to or not.
  virtual Result<std::uint64_t> stored_bytes(const std::string& owner) = 0;
  virtual Result<std::uint64_t> free_bytes() = 0;  // that are left for blobs
  virtual Result<Done> check() = 0;                // that something can be stored, by storing it

 protected:
  Reservations& reservations() { return *reservations_; }

 private:
  const std::unique_ptr<Reservations> reservations_;
};

}  // namespace meshgauge::server::store
