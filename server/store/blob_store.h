// Bytes named by their SHA-256, separate for each owner: owners share no bytes, and equal bytes of another owner
// neither show nor speed up anything.
//
// All calls are thread safe. Errors as in job_store.h: storage_full, storage_unavailable, internal. No blob is ever
// visible half written.
//
// Order for a caller that is going to refer to a blob (in a job or a mesh): reserve(), then put() or renew(), then
// store the reference. remove_unreferenced() keeps a reserved blob. remove_unused() may run at any time, also in
// another process: put() and renew() protect a blob from it for `older_than`.
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

#include "api/base/descriptor.h"
#include "engine/result.h"

namespace meshgauge::server::store {

struct BlobKey {
  std::string owner;
  std::string id;  // SHA-256 of the bytes, 64 lower-case hex digits; any other text names no blob
  bool operator==(const BlobKey&) const = default;
};

// The bytes of a blob, mapped. They stay readable when the blob is removed.
class Blob {
 public:
  Blob(Descriptor file, std::span<const std::byte> mapped) : file_(std::move(file)), bytes_(mapped) {}
  Blob(Blob&& other) noexcept : file_(std::move(other.file_)), bytes_(std::exchange(other.bytes_, {})) {}
  Blob& operator=(Blob&&) = delete;
  ~Blob();

  static Result<Blob> map(Descriptor file);  // the whole file, which must not change any more

  std::uint64_t size() const { return bytes_.size(); }
  std::span<const std::byte> bytes() const { return bytes_; }
  int file() const { return file_.get(); }  // a read-only descriptor of the same bytes

 private:
  Descriptor file_;
  std::span<const std::byte> bytes_;  // mapped; unmapped by the destructor
};

// Blobs that a sweep would remove.
struct UnusedBlobs {
  std::uint64_t number = 0;
  std::chrono::sys_time<std::chrono::milliseconds> oldest = decltype(oldest)::max();  // last put or renewed then
};

enum class BlobPut {
  created,
  existed,
  other_digest,  // the SHA-256 of the bytes is not the id: nothing is stored
};

// The blobs that callers are going to refer to. This class knows the reservations of one process; a derived class that
// overrides begin(), end() and unless_held() shares them between processes. Thread safe.
class Reservations {
 public:
  // Reserves one blob during its lifetime.
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

  // Calls work() and returns its value, unless the blob (by its blob_name()) is reserved: then false. Reservations of
  // the blob that begin meanwhile wait for work().
  virtual Result<bool> unless_held(const std::string& name, const std::function<Result<bool>()>& work);

 protected:
  virtual void begin(const std::string& name);  // waits for work() of the same name
  virtual void end(const std::string& name);    // once for each begin()

 private:
  std::mutex mutex_;
  std::condition_variable done_;
  std::multiset<std::string> held_;
  std::set<std::string> closed_;  // work() runs for these
};

class BlobStore {
 public:
  BlobStore() : BlobStore(std::make_unique<Reservations>()) {}
  explicit BlobStore(std::unique_ptr<Reservations> reservations) : reservations_(std::move(reservations)) {}
  BlobStore(const BlobStore&) = delete;
  BlobStore& operator=(const BlobStore&) = delete;
  virtual ~BlobStore() = default;

  Reservations::Held reserve(const BlobKey& key) { return {*reservations_, key}; }

  // Stores the bytes; durable when it returns. Checks the digest of the bytes that are written. Reads a blob that
  // exists already, and replaces it if it is damaged. Keeps no reference to the bytes.
  virtual Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) = 0;

  virtual Result<std::optional<Blob>> open(const BlobKey& key) = 0;  // nullopt: no such blob
  virtual Result<bool> exists(const BlobKey& key) = 0;
  virtual Result<bool> renew(const BlobKey& key) = 0;   // makes it as young as put() does; false: no such blob
  virtual Result<bool> remove(const BlobKey& key) = 0;  // used or not; false: no such blob
  // Removes the blob unless it is reserved or `referenced` returns true. false: it stays, or did not exist.
  Result<bool> remove_unreferenced(const BlobKey& key, const std::function<Result<bool>()>& referenced);
  // Counts what remove_unused() would remove.
  virtual Result<UnusedBlobs> count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) = 0;
  // Removes blobs that are not in `used` and were neither put nor renewed within `older_than`; returns their number.
  virtual Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) = 0;

  // The bytes of all blobs of an owner, referred to or not.
  virtual Result<std::uint64_t> stored_bytes(const std::string& owner) = 0;
  virtual Result<std::uint64_t> free_bytes() = 0;  // left for blobs; the largest number: unknown
  virtual Result<Done> check() = 0;                // stores something and removes it: can blobs be stored?

 protected:
  Reservations& reservations() { return *reservations_; }

 private:
  const std::unique_ptr<Reservations> reservations_;
};

}  // namespace meshgauge::server::store
