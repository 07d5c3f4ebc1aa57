// Blobs that are kept elsewhere, as files in a folder of this machine: the least recently used go when they take more
// bytes than they may.
//
//   <folder>/incoming/<random>                     being fetched; removed at the start
//   <folder>/<first two digits>/<id>.<SHA-256 of the owner>
//
// No blob comes out whose digest is not its id. It is computed as the bytes come in, and again when a file is opened
// for the first time after a start, so nothing need be synced; after that a file is trusted as long as its inode, size
// and times are those that were seen with the right digest. Files are renamed into place when they are whole. The order
// of use survives a restart, by the files' times.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "engine/lazy.h"
#include "server/store/blob_store.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

// Thread safe.
class BlobCache {
 public:
  // Gives the bytes of a blob, each once and in order; false: there is none.
  using Fetch = std::function<Result<bool>(const RemoteBlobs::Take& take)>;

  struct Counters {
    std::uint64_t hits = 0, misses = 0;
    std::uint64_t refused = 0;  // bytes that came with another digest, and files that were damaged
    std::uint64_t bytes = 0, files = 0;
  };

  // `folder` is used by this object alone; it is made when there is none, but not the folder around it. Files beyond
  // `max_bytes` are removed.
  static Result<std::unique_ptr<BlobCache>> open(const std::string& folder, std::uint64_t max_bytes);

  // nullopt: fetch() says that there is none. Whoever asks for a blob that is being fetched waits for that and shares
  // its end, errors too. A blob larger than all that may be kept comes through, and is not kept. Bytes of another
  // digest are fetched once more, then refused (internal). A disk without room is cleared before that is an error.
  // Precondition: is_blob_id(key.id).
  Result<std::optional<Blob>> get(const BlobKey& key, const Fetch& fetch);
  void forget(const BlobKey& key);

  Counters counters() const;

 private:
  struct Incoming;  // a file that is being written

  using Order = std::list<std::string>;  // names, the most recently used first

  // By which a file is known again.
  struct Stamp {
    std::uint64_t inode = 0, size = 0;
    std::int64_t modified_ns = 0, changed_ns = 0;
    bool operator==(const Stamp&) const = default;
  };

  struct Entry {
    Order::iterator place;
    std::uint64_t bytes = 0;
    std::optional<Stamp> sound;  // of the file when its digest was right; none: since the start nobody has looked
  };

  // What a fetch ended with.
  struct Landed {
    std::shared_ptr<const Descriptor> file;  // none: there is no such blob
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
  bool remove_oldest();  // false: there is none
  void make_room();

  const std::string folder_;
  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;  // of all below, and of the names of files
  Order order_;
  std::unordered_map<std::string, Entry> entries_;
  std::unordered_map<std::string, std::shared_ptr<Lazy<Landed>>> flights_;
  std::uint64_t bytes_ = 0;
  std::uint64_t incoming_ = 0;  // of files that are being written
  std::uint64_t hits_ = 0, misses_ = 0, refused_ = 0;
};

}  // namespace meshgauge::server::store
