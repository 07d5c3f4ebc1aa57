#include "server/store/blob_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <tuple>
#include <vector>

#include "api/base/digest.h"
#include "server/store/data_folder.h"

namespace meshgauge::server::store {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kTouchedNs = 60'000'000'000;  // precision of the order of use after a restart

Error not_kept(int error_number) {
  return storage_error(error_number, "the stored mesh cannot be cached on this disk");
}

// By pread(): the file may be cut off meanwhile. "": it cannot be read.
std::string digest_of(int file) {
  api::Sha256 digest;
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  for (off_t offset = 0;;) {
    const ssize_t n = ::pread(file, buffer.data(), buffer.size(), offset);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return "";
    if (n == 0) return digest.hex();
    digest.update(std::span(buffer).first(static_cast<std::size_t>(n)));
    offset += n;
  }
}

std::string name_of(const BlobKey& key) { return key.id + "." + api::sha256_hex(std::as_bytes(std::span(key.owner))); }

bool is_name(const std::string& name) {
  return name.size() == 129 && name[64] == '.' && is_blob_id(name.substr(0, 64)) && is_blob_id(name.substr(65));
}

std::int64_t nanoseconds_of(const timespec& time) { return time.tv_sec * 1'000'000'000 + time.tv_nsec; }

std::int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return nanoseconds_of(now);
}

// Returns errno, or 0.
int write_at(int file, std::uint64_t offset, std::span<const std::byte>& left) {
  while (!left.empty()) {
    const ssize_t n = ::pwrite(file, left.data(), left.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    left = left.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return 0;
}

}  // namespace

// Removed by the destructor unless it was moved to its place.
struct BlobCache::Incoming {
  explicit Incoming(BlobCache& of)
      : cache(of),
        path(of.folder_ + kIncoming + "/" + api::random_id()),
        file(open_file(path, O_RDWR | O_CREAT | O_EXCL)) {}
  ~Incoming() {
    if (!path.empty() && file) ::unlink(path.c_str());
    const std::lock_guard lock(cache.mutex_);
    cache.incoming_ -= bytes;
  }
  Incoming(const Incoming&) = delete;
  Incoming& operator=(const Incoming&) = delete;

  BlobCache& cache;
  std::string path;  // empty: it was moved
  Descriptor file;
  api::Sha256 digest;
  std::uint64_t bytes = 0;
};

Result<std::unique_ptr<BlobCache>> BlobCache::open(const std::string& folder, std::uint64_t max_bytes) {
  std::unique_ptr<BlobCache> cache(new BlobCache(folder, max_bytes));
  Result<Done> prepared = cache->prepare();
  if (!prepared) return prepared.error();
  return cache;
}

std::string BlobCache::path_of(const std::string& name) const { return folder_ + "/" + name.substr(0, 2) + "/" + name; }

Result<Done> BlobCache::prepare() {
  std::error_code failed;
  fs::remove_all(folder_ + kIncoming, failed);
  if (failed) return not_kept(failed.value());
  for (const std::string& folder : {folder_, folder_ + kIncoming}) {
    Result<bool> made = make_folder(folder);
    if (!made) return made.error();
  }
  return find_files();
}

Result<Done> BlobCache::find_files() {
  std::vector<std::tuple<std::int64_t, std::string, std::uint64_t>> found;
  std::error_code failed;
  fs::recursive_directory_iterator entry(folder_, failed);
  for (; !failed && entry != fs::recursive_directory_iterator(); entry.increment(failed)) {
    struct stat status {};
    const std::string name = entry->path().filename();
    if (entry.depth() != 1 || !is_name(name) || ::lstat(entry->path().c_str(), &status) != 0) continue;
    if (S_ISREG(status.st_mode)) {
      found.emplace_back(nanoseconds_of(status.st_mtim), name, static_cast<std::uint64_t>(status.st_size));
    }
  }
  if (failed) return not_kept(failed.value());
  std::sort(found.begin(), found.end());
  const std::lock_guard lock(mutex_);
  for (const auto& [used, name, bytes] : found) insert(name, bytes, std::nullopt);
  make_room();
  return Done{};
}

Result<std::optional<Blob>> BlobCache::get(const BlobKey& key, const Fetch& fetch) {
  const std::string name = name_of(key);
  for (;;) {
    Result<std::optional<Blob>> kept = open_kept(name, key.id);
    if (!kept || *kept) return kept;
    std::unique_lock lock(mutex_);
    if (entries_.contains(name)) continue;  // just fetched
    auto& known = flights_[name];
    if (!known) {
      known = std::make_shared<Lazy<Landed>>();
      ++misses_;
    }
    const auto flight = known;
    lock.unlock();
    const Landed* landed = flight->get(
        never_interrupted, [&] { return std::make_unique<const Landed>(fetch_twice(name, key.id, fetch)); });
    lock.lock();
    if (const auto at = flights_.find(name); at != flights_.end() && at->second == flight) flights_.erase(at);
    lock.unlock();
    return blob_of(*landed);
  }
}

void BlobCache::forget(const BlobKey& key) {
  const std::lock_guard lock(mutex_);
  remove(name_of(key));
}

BlobCache::Counters BlobCache::counters() const {
  const std::lock_guard lock(mutex_);
  return {hits_, misses_, refused_, bytes_, entries_.size()};
}

// Each caller gets a descriptor with a file position of its own.
Result<std::optional<Blob>> BlobCache::blob_of(const Landed& landed) {
  if (landed.error) return *landed.error;
  if (!landed.file) return std::optional<Blob>();
  const std::string path = "/proc/self/fd/" + std::to_string(landed.file->get());
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return storage_error(errno, "the stored mesh cannot be read");
  Result<Blob> blob = Blob::map(std::move(file));
  if (!blob) return blob.error();
  return std::optional(std::move(*blob));
}

std::optional<BlobCache::Stamp> BlobCache::stamp_of(int file) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return std::nullopt;
  return Stamp{status.st_ino, static_cast<std::uint64_t>(status.st_size), nanoseconds_of(status.st_mtim),
               nanoseconds_of(status.st_ctim)};
}

// nullopt: not in the cache.
Result<std::optional<Blob>> BlobCache::open_kept(const std::string& name, const std::string& id) {
  std::unique_lock lock(mutex_);
  const auto found = entries_.find(name);
  if (found == entries_.end()) return std::optional<Blob>();
  Descriptor file(::open(path_of(name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  const std::optional<Stamp> seen = file ? stamp_of(file.get()) : std::nullopt;
  if (!seen) {
    remove(name);
    return std::optional<Blob>();
  }
  if (found->second.sound == seen) {
    touch(found->second, file.get());
  } else {
    lock.unlock();
    const bool sound = prove(name, id, file, *seen);
    lock.lock();
    if (!sound) return std::optional<Blob>();
  }
  ++hits_;
  lock.unlock();
  Result<Blob> blob = Blob::map(std::move(file));
  if (!blob) return blob.error();
  return std::optional(std::move(*blob));
}

// Reads the whole file; removes it if it is damaged or cannot be read.
bool BlobCache::prove(const std::string& name, const std::string& id, const Descriptor& file, const Stamp& seen) {
  const bool sound = digest_of(file.get()) == id;
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(name);
  if (!sound) {
    ++refused_;
    remove(name);
    return false;
  }
  if (found == entries_.end()) return true;  // removed meanwhile, but the bytes are right
  found->second.sound = seen;
  touch(found->second, file.get());
  return true;
}

BlobCache::Landed BlobCache::fetch_twice(const std::string& name, const std::string& id, const Fetch& fetch) try {
  for (int i = 0; i < 2; ++i) {
    if (std::optional<Landed> landed = fetch_once(name, id, fetch)) return *landed;
    const std::lock_guard lock(mutex_);
    ++refused_;
  }
  return {nullptr, Error{ErrorCode::internal,
                         "the stored mesh is damaged: its bytes have another SHA-256; upload it again", "", ""}};
} catch (const std::exception& error) {
  // Calls that wait for this fetch must be woken.
  return {nullptr, Error{ErrorCode::internal, error.what(), "", ""}};
}

// nullopt: the bytes have another digest.
std::optional<BlobCache::Landed> BlobCache::fetch_once(const std::string& name, const std::string& id,
                                                       const Fetch& fetch) {
  Incoming incoming(*this);
  if (!incoming.file) return Landed{nullptr, not_kept(errno)};
  const Result<bool> fetched = fetch([&](std::span<const std::byte> piece) { return write(incoming, piece); });
  if (!fetched) return Landed{nullptr, fetched.error()};
  if (!*fetched) return Landed{nullptr, std::nullopt};
  if (incoming.digest.hex() != id) return std::nullopt;
  auto readable = std::make_shared<Descriptor>(::open(incoming.path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!*readable) return Landed{nullptr, not_kept(errno)};
  incoming.file.close();
  keep(incoming, name);
  return Landed{std::move(readable), std::nullopt};
}

Result<Done> BlobCache::write(Incoming& incoming, std::span<const std::byte> piece) {
  incoming.digest.update(piece);
  {
    const std::lock_guard lock(mutex_);
    incoming_ += piece.size();
    make_room();
  }
  const std::uint64_t offset = incoming.bytes;
  incoming.bytes += piece.size();
  std::span<const std::byte> left = piece;
  for (;;) {
    const int failure = write_at(incoming.file.get(), offset + (piece.size() - left.size()), left);
    if (failure == 0) return Done{};
    const std::lock_guard lock(mutex_);
    if (!means_full(failure) || !remove_oldest()) return not_kept(failure);
  }
}

// Errors are ignored: the blob is then not cached.
void BlobCache::keep(Incoming& incoming, const std::string& name) {
  if (incoming.bytes > max_bytes_) return;
  const std::string path = path_of(name);
  if (!make_folder(fs::path(path).parent_path())) return;
  const std::lock_guard lock(mutex_);
  remove(name);
  if (::rename(incoming.path.c_str(), path.c_str()) != 0) return;
  incoming.path.clear();
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  insert(name, incoming.bytes, file ? stamp_of(file.get()) : std::nullopt);
  incoming_ -= incoming.bytes;
  incoming.bytes = 0;
  make_room();
}

void BlobCache::insert(const std::string& name, std::uint64_t bytes, const std::optional<Stamp>& sound) {
  order_.push_front(name);
  entries_[name] = {order_.begin(), bytes, sound};
  bytes_ += bytes;
}

void BlobCache::touch(Entry& entry, int file) {
  order_.splice(order_.begin(), order_, entry.place);
  if (!entry.sound || now_ns() - entry.sound->modified_ns < kTouchedNs) return;
  if (::futimens(file, nullptr) == 0) entry.sound = stamp_of(file);
}

void BlobCache::remove(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) return;
  ::unlink(path_of(name).c_str());
  bytes_ -= found->second.bytes;
  order_.erase(found->second.place);
  entries_.erase(found);
}

bool BlobCache::remove_oldest() {
  if (order_.empty()) return false;
  remove(std::string(order_.back()));
  return true;
}

void BlobCache::make_room() {
  while (bytes_ + incoming_ > max_bytes_ && remove_oldest()) {
  }
}

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
  return remote_->remove_unused(used, older_than, reservations());
}

Result<std::uint64_t> CachedBlobs::stored_bytes(const std::string& owner) { return remote_->stored_bytes(owner); }

Result<std::uint64_t> CachedBlobs::free_bytes() { return remote_->free_bytes(); }

Result<Done> CachedBlobs::check() { return remote_->check(); }

}  // namespace meshgauge::server::store
