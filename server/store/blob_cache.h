// A cache of remote blobs: files in a folder of this machine. Beyond a number of bytes the least recently used are
// removed. CachedBlobs is the BlobStore of both.
//
//   <folder>/incoming/<random>                     being fetched; removed at the start
//   <folder>/<first two digits>/<id>.<SHA-256 of the owner>
//
// Every blob that is returned has the digest that its id names. The digest is computed as the bytes arrive, and again
// when a file is first opened after a start, so files need no sync. After that a file is trusted while its inode, size
// and times are those that it had then. Files are renamed into place when they are complete. The order of use survives
// a restart, by the files' times.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "engine/tree/lazy.h"
#include "server/store/blob_store.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

// Thread safe.
class BlobCache {
 public:
  // Passes the bytes of a blob on, each once and in order; false: no such blob.
  using Fetch = std::function<Result<bool>(const RemoteBlobs::Take& take)>;

  struct Counters {
    std::uint64_t hits = 0, misses = 0;
    std::uint64_t refused = 0;  // fetches with another digest, and damaged files
    std::uint64_t bytes = 0, files = 0;
  };

  // Creates `folder` if needed, but not its parent. No other object may use it. Removes files beyond `max_bytes`.
  static Result<std::unique_ptr<BlobCache>> open(const std::string& folder, std::uint64_t max_bytes);

  // Returns the blob, fetched unless it is cached; nullopt: fetch() returned false. Concurrent calls for one blob share
  // one fetch and its error. A blob larger than the cache is returned and not kept. Bytes with another digest are
  // fetched once more, then an error (internal). A full disk is cleared first, before it is an error.
  // Precondition: is_blob_id(key.id).
  Result<std::optional<Blob>> get(const BlobKey& key, const Fetch& fetch);
  void forget(const BlobKey& key);

  Counters counters() const;

 private:
  struct Incoming;  // a file while it is written

  using Order = std::list<std::string>;  // names, the most recently used first

  // Identifies a file that has not changed.
  struct Stamp {
    std::uint64_t inode = 0, size = 0;
    std::int64_t modified_ns = 0, changed_ns = 0;
    bool operator==(const Stamp&) const = default;
  };

  struct Entry {
    Order::iterator place;
    std::uint64_t bytes = 0;
    std::optional<Stamp> sound;  // of the file when its digest was right; nullopt: not checked since the start
  };

  // The end of a fetch.
  struct Landed {
    std::shared_ptr<const Descriptor> file;  // null: no such blob
    std::optional<Error> error;
  };

  BlobCache(std::string folder, std::uint64_t max_bytes) : folder_(std::move(folder)), max_bytes_(max_bytes) {}

  static std::optional<Stamp> stamp_of(int file);
  static Result<std::optional<Blob>> blob_of(const Landed& landed);
  std::string path_of(const std::string& name) const;
  Result<Done> prepare();
  Result<Done> find_files();
  Result<std::optional<Blob>> open_kept(const std::string& name, const std::string& id);
  bool prove(const std::string& name, const std::string& id, const Descriptor& file, const Stamp& seen);
  Landed fetch_twice(const std::string& name, const std::string& id, const Fetch& fetch);
  std::optional<Landed> fetch_once(const std::string& name, const std::string& id, const Fetch& fetch);
  Result<Done> write(Incoming& incoming, std::span<const std::byte> piece);
  void keep(Incoming& incoming, const std::string& name);

  // Under the lock.
  void insert(const std::string& name, std::uint64_t bytes, const std::optional<Stamp>& sound);
  void touch(Entry& entry, int file);
  void remove(const std::string& name);
  bool remove_oldest();  // false: the cache is empty
  void make_room();

  const std::string folder_;
  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;  // guards the members below, and the names of files
  Order order_;
  std::unordered_map<std::string, Entry> entries_;
  std::unordered_map<std::string, std::shared_ptr<Lazy<Landed>>> flights_;
  std::uint64_t bytes_ = 0;
  std::uint64_t incoming_ = 0;  // bytes of files that are being written
  std::uint64_t hits_ = 0, misses_ = 0, refused_ = 0;
};

// A BlobStore over remote blobs: the remote store decides which blobs exist, the cache has their bytes.
//
// open() of a cached blob does not ask the remote store, so it works while that does not answer, and may return a blob
// that another process has removed. That is safe: rows of jobs and meshes decide which owner may read a blob.
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
