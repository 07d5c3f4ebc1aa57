#include "server/store/file_blobs.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "api/base/digest.h"
#include "server/store/data_folder.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> as_bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

// A file that cannot be read counts as missing: a disk may have lost it.
bool holds(const Descriptor& file, std::span<const std::byte> bytes) {
  std::vector<std::byte> buffer(std::min(bytes.size(), std::size_t{1} << 20));
  for (std::size_t done = 0; done < bytes.size();) {
    const std::size_t wanted = std::min(bytes.size() - done, buffer.size());
    const ssize_t n = ::pread(file.get(), buffer.data(), wanted, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0 || std::memcmp(bytes.data() + done, buffer.data(), static_cast<std::size_t>(n)) != 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

constexpr const char* kTrial = "/check";  // below the root, where no blob is: a file that check() moves there

Error not_stored(int error_number) { return storage_error(error_number, "the mesh cannot be stored"); }
// For callers, clients among them: without the path that the error names.
Error not_stored(const Error& error) { return {error.code, "the mesh cannot be stored: its folder fails", "", ""}; }
Error not_read(int error_number) { return storage_error(error_number, "the stored mesh cannot be read"); }
Error not_removed(int error_number) { return storage_error(error_number, "the stored mesh cannot be removed"); }

// A file that the destructor removes unless it was moved to its place.
class Incoming {
 public:
  explicit Incoming(const std::string& root) : path_(root + kIncoming + "/" + api::random_id()) {
    file_ = open_file(path_, O_WRONLY | O_CREAT | O_EXCL);
  }
  ~Incoming() {
    if (file_) ::unlink(path_.c_str());
  }
  Incoming(const Incoming&) = delete;
  Incoming& operator=(const Incoming&) = delete;

  const Descriptor& file() const { return file_; }
  const std::string& path() const { return path_; }
  bool sync() const { return ::fsync(file_.get()) == 0; }

 private:
  std::string path_;
  Descriptor file_;
};

Result<Done> remove_all_in(const std::string& folder) {
  std::error_code failed;
  fs::directory_iterator entry(folder, failed);
  for (; !failed && entry != fs::directory_iterator(); entry.increment(failed)) {
    if (::unlink(entry->path().c_str()) != 0) return not_removed(errno);
  }
  if (failed) return not_removed(failed.value());
  return Done{};
}

// Calls visit(path) for each blob: each file two folders below the root. Files of `incoming` are not that deep.
template <class Visit>
std::error_code for_each_blob(const std::string& root, Visit visit) {
  std::error_code failed;
  fs::recursive_directory_iterator entry(root, failed);
  for (; !failed && entry != fs::recursive_directory_iterator(); entry.increment(failed)) {
    if (entry.depth() == 2 && is_blob_id(entry->path().filename())) visit(entry->path().string());
  }
  return failed;
}

// 0: there is none.
std::uint64_t size_of(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

std::chrono::sys_time<std::chrono::nanoseconds> modified(const struct stat& status) {
  return std::chrono::sys_time<std::chrono::nanoseconds>(std::chrono::seconds(status.st_mtim.tv_sec) +
                                                         std::chrono::nanoseconds(status.st_mtim.tv_nsec));
}

bool is_older(const struct stat& status, std::chrono::seconds age) {
  return std::chrono::system_clock::now() - modified(status) >= age;
}

}  // namespace

struct FileBlobs::Place {
  std::string owner_folder;
  std::string folder;
  std::string path;
};

Result<std::unique_ptr<FileBlobs>> FileBlobs::open(const std::string& root, Reserve* reserve) {
  std::unique_ptr<FileBlobs> blobs(new FileBlobs(root, reserve));
  Result<Done> prepared = blobs->prepare();
  if (!prepared) return prepared.error();
  return blobs;
}

Result<Done> FileBlobs::prepare() {
  for (const std::string& folder : {root_, root_ + kIncoming}) {
    Result<bool> made = make_folder(folder);
    if (!made) return made.error();
  }
  Result<Done> synced = sync_folder(fs::path(root_).parent_path());
  if (!synced) return synced;
  if (Result<Done> removed = remove_all_in(root_ + kIncoming); !removed) return removed;
  return weigh();
}

Result<Done> FileBlobs::weigh() {
  const std::error_code failed =
      for_each_blob(root_, [this](const std::string& path) { count(path, 0, size_of(path)); });
  if (failed) return not_read(failed.value());
  return Done{};
}

void FileBlobs::count(const std::string& path, std::uint64_t before, std::uint64_t after) {
  const std::lock_guard lock(bytes_mutex_);
  std::uint64_t& bytes = bytes_[fs::path(path).parent_path().parent_path()];
  bytes += after - before;
}

// Precondition: the lock of this path is held.
bool FileBlobs::unlink(const std::string& path) {
  const std::uint64_t size = size_of(path);
  if (::unlink(path.c_str()) != 0) return false;
  count(path, size, 0);
  return true;
}

Result<std::uint64_t> FileBlobs::stored_bytes(const std::string& owner) {
  const std::lock_guard lock(bytes_mutex_);
  const auto found = bytes_.find(place_of({owner, std::string(64, '0')}).owner_folder);
  return found == bytes_.end() ? 0 : found->second;
}

FileBlobs::Place FileBlobs::place_of(const BlobKey& key) const {
  Place place;
  place.owner_folder = root_ + "/" + api::sha256_hex(as_bytes(key.owner));
  place.folder = place.owner_folder + "/" + key.id.substr(0, 2);
  place.path = place.folder + "/" + key.id;
  return place;
}

std::mutex& FileBlobs::lock_of(const std::string& path) {
  return locks_[std::hash<std::string>()(path) % locks_.size()];
}

Result<BlobPut> FileBlobs::put(const BlobKey& key, std::span<const std::byte> bytes) {
  if (!is_blob_id(key.id) || api::sha256_hex(bytes) != key.id) return BlobPut::other_digest;
  const Place place = place_of(key);
  const Result<bool> again = put_again(place, bytes);
  if (!again) return again.error();
  if (*again) return BlobPut::existed;
  if (const Result<Done> put = put_anew(place, bytes); !put) return put.error();
  return BlobPut::created;
}

// false: there is no such file, or it holds other bytes and a new file is to replace it.
Result<bool> FileBlobs::put_again(const Place& place, std::span<const std::byte> bytes) {
  const Descriptor there(::open(place.path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  struct stat status {};
  if (!there || ::fstat(there.get(), &status) != 0 || static_cast<std::uint64_t>(status.st_size) != bytes.size()) {
    return false;
  }
  if (!holds(there, bytes)) return false;
  Result<bool> renewed = renew(place);
  if (!renewed || !*renewed) return renewed;
  // Another call may have moved it here without having synced its name yet.
  const Result<Done> synced = sync_folder(place.folder);
  if (!synced) return not_stored(synced.error());
  return true;
}

Result<Done> FileBlobs::put_anew(const Place& place, std::span<const std::byte> bytes) {
  if (reserve_ && !reserve_->restore()) return not_stored(errno);
  const Incoming incoming(root_);
  if (!incoming.file()) return not_stored(errno);
  if (!write_all(incoming.file().get(), bytes)) return not_stored(errno);
  if (!incoming.sync()) return not_stored(errno);
  return move_in(incoming.path(), place);
}

Result<Done> FileBlobs::move_in(const std::string& incoming, const Place& place) {
  Result<Done> made = make_durable_folder(place.owner_folder, root_);
  if (made) made = make_durable_folder(place.folder, place.owner_folder);
  if (!made) return made;
  {
    const std::lock_guard lock(lock_of(place.path));
    const std::uint64_t before = size_of(place.path);
    const std::uint64_t size = size_of(incoming);
    if (::rename(incoming.c_str(), place.path.c_str()) != 0) return not_stored(errno);
    count(place.path, before, size);
  }
  const Result<Done> synced = sync_folder(place.folder);
  if (!synced) return not_stored(synced.error());
  return Done{};
}

Result<Done> FileBlobs::make_durable_folder(const std::string& path, const std::string& around) {
  {
    std::error_code failed;
    const std::lock_guard lock(folders_mutex_);
    if (durable_folders_.contains(path) && fs::is_directory(path, failed)) return Done{};
  }
  const Result<bool> made = make_folder(path);
  if (!made) return not_stored(made.error());
  const Result<Done> synced = sync_folder(around);
  if (!synced) return not_stored(synced.error());
  const std::lock_guard lock(folders_mutex_);
  durable_folders_.insert(path);
  return Done{};
}

Result<std::optional<Blob>> FileBlobs::open(const BlobKey& key) {
  if (!is_blob_id(key.id)) return std::optional<Blob>();
  Descriptor file(::open(place_of(key).path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file && errno == ENOENT) return std::optional<Blob>();
  if (!file) return not_read(errno);
  Result<Blob> blob = Blob::map(std::move(file));
  if (!blob) return blob.error();
  return std::optional(std::move(*blob));
}

Result<bool> FileBlobs::exists(const BlobKey& key) {
  struct stat status {};
  if (!is_blob_id(key.id)) return false;
  if (::stat(place_of(key).path.c_str(), &status) == 0) return true;
  if (errno == ENOENT) return false;
  return not_read(errno);
}

Result<bool> FileBlobs::renew(const BlobKey& key) {
  if (!is_blob_id(key.id)) return false;
  return renew(place_of(key));
}

Result<bool> FileBlobs::renew(const Place& place) {
  const std::lock_guard lock(lock_of(place.path));
  if (::utimensat(AT_FDCWD, place.path.c_str(), nullptr, 0) == 0) return true;
  if (errno == ENOENT) return false;
  return not_stored(errno);
}

Result<bool> FileBlobs::remove(const BlobKey& key) {
  if (!is_blob_id(key.id)) return false;
  const std::string path = place_of(key).path;
  const std::lock_guard lock(lock_of(path));
  if (unlink(path)) return true;
  if (errno == ENOENT) return false;
  return not_removed(errno);
}

// Calls visit(path, status) under the blob's lock.
template <class Visit>
std::error_code FileBlobs::for_each_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                           Visit visit) {
  std::unordered_set<std::string> kept;
  for (const BlobKey& key : used) kept.insert(place_of(key).path);
  return for_each_blob(root_, [&](const std::string& path) {
    if (kept.contains(path)) return;
    const std::lock_guard lock(lock_of(path));
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0 && is_older(status, older_than)) visit(path, status);
  });
}

Result<UnusedBlobs> FileBlobs::count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) {
  UnusedBlobs unused;
  const std::error_code failed = for_each_unused(used, older_than, [&](const std::string&, const struct stat& status) {
    ++unused.number;
    unused.oldest = std::min(unused.oldest, std::chrono::floor<std::chrono::milliseconds>(modified(status)));
  });
  if (failed) return not_read(failed.value());
  return unused;
}

Result<std::uint64_t> FileBlobs::remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) {
  std::uint64_t removed = 0;
  int failure = 0;
  const std::error_code failed = for_each_unused(used, older_than, [&](const std::string& path, const struct stat&) {
    if (unlink(path)) {
      ++removed;
    } else if (errno != ENOENT) {
      failure = errno;
    }
  });
  if (failure != 0) return not_removed(failure);
  if (failed) return not_removed(failed.value());
  return removed;
}

Result<std::uint64_t> FileBlobs::free_bytes() {
  struct statvfs status {};
  if (::statvfs(root_.c_str(), &status) != 0) return not_read(errno);
  return std::uint64_t{status.f_bavail} * status.f_frsize;
}

Result<Done> FileBlobs::check() {
  if (reserve_ && !reserve_->restore()) return not_stored(errno);
  const Incoming incoming(root_);
  const std::vector<std::byte> block(4096);
  if (!incoming.file() || !write_all(incoming.file().get(), block) || !incoming.sync()) return not_stored(errno);
  const std::string moved = root_ + kTrial;
  if (::rename(incoming.path().c_str(), moved.c_str()) != 0 || ::unlink(moved.c_str()) != 0) return not_stored(errno);
  return Done{};
}

}  // namespace meshgauge::server::store
