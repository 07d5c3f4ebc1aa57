#include "server/measure/map_cache.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <span>
#include <streambuf>

#include "api/base/descriptor.h"
#include "api/base/digest.h"
#include "server/http/upload.h"
#include "server/store/data_folder.h"

namespace meshgauge::server {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kKeptFree = 64;  // of a small disk only this fraction is kept free

Error not_written(int error_number) { return store::storage_error(error_number, "the deviation map cannot be kept"); }

void remove_all(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) ::unlink(path.c_str());
}

Result<MapCache::File> mapped(Descriptor file) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return not_written(errno);
  const auto size = static_cast<std::size_t>(status.st_size);
  const void* start = size == 0 ? nullptr : ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (start == MAP_FAILED) return not_written(errno);
  return MapCache::File(
      std::make_shared<const store::Blob>(std::move(file), std::span(static_cast<const std::byte*>(start), size)));
}

// A buffer for a std::ostream that writes to a borrowed descriptor.
class FileBuffer final : public std::streambuf {
 public:
  explicit FileBuffer(int file) : file_(file) { setp(buffer_.data(), buffer_.data() + buffer_.size()); }

  // Writes the rest. false: a write failed; error_number() has its errno.
  bool finish() { return flush_buffer(); }
  int error_number() const { return error_number_; }

 private:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override { return flush_buffer() ? 0 : -1; }
  bool flush_buffer();
  bool write_all(const char* bytes, std::size_t count);

  const int file_;
  int error_number_ = 0;
  std::array<char, std::size_t{64} << 10> buffer_;
};

FileBuffer::int_type FileBuffer::overflow(int_type c) {
  if (!flush_buffer()) return traits_type::eof();
  if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
  return traits_type::not_eof(c);
}

std::streamsize FileBuffer::xsputn(const char* bytes, std::streamsize count) {
  if (count <= epptr() - pptr()) return std::streambuf::xsputn(bytes, count);
  return flush_buffer() && write_all(bytes, static_cast<std::size_t>(count)) ? count : 0;
}

bool FileBuffer::flush_buffer() {
  const auto waiting = static_cast<std::size_t>(pptr() - pbase());
  setp(buffer_.data(), buffer_.data() + buffer_.size());
  return write_all(buffer_.data(), waiting);
}

bool FileBuffer::write_all(const char* bytes, std::size_t count) {
  if (error_number_ == 0 && !meshgauge::write_all(file_, std::as_bytes(std::span(bytes, count)))) error_number_ = errno;
  return error_number_ == 0;
}

Result<MapCache::File> written(Descriptor file, const MapCache::Write& write) {
  if (!file) return not_written(errno);
  FileBuffer buffer(file.get());
  std::ostream out(&buffer);
  if (auto done = write(out); !done) return done.error();
  if (!buffer.finish()) return not_written(buffer.error_number());
  return mapped(std::move(file));
}

bool is_of_storage(const Error& error) {
  return error.code == ErrorCode::storage_full || error.code == ErrorCode::storage_unavailable;
}

}  // namespace

Result<Done> MapCache::open() {
  if (settings_.max_bytes == 0) return Done{};
  if (const auto made = store::make_folder(settings_.folder); !made) return made.error();
  std::error_code failed;
  fs::directory_iterator entry(settings_.folder, failed);
  for (; !failed && entry != fs::directory_iterator(); entry.increment(failed)) {
    if (::unlink(entry->path().c_str()) != 0) return not_written(errno);
  }
  if (failed) return not_written(failed.value());
  return Done{};
}

MapCache::File MapCache::find(const MapKey& key) {
  const std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return nullptr;
  auto file = mapped(Descriptor(::open(found->second->path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)));
  if (!file) return nullptr;
  entries_.splice(entries_.end(), entries_, found->second);
  return std::move(*file);
}

std::shared_ptr<MapCache::Coming> MapCache::expect(const MapKey& key, const std::vector<std::string>& meshes) {
  const auto coming = std::make_shared<Coming>();
  coming->key = key;
  coming->meshes = meshes;
  const std::lock_guard lock(mutex_);
  std::erase_if(coming_, [](const auto& one) { return one.expired(); });
  coming_.push_back(coming);
  return coming;
}

Result<MapCache::File> MapCache::keep(const Coming& coming, const Write& write) {
  if (settings_.max_bytes == 0) return write_unnamed(write);
  const std::string path = settings_.folder + "/" + api::random_id();
  auto file = write_named(path + ".part", write);
  if (!file && !is_of_storage(file.error())) return file;
  if (!file) {
    give_way();
    return write_unnamed(write);
  }
  const bool kept = ::rename((path + ".part").c_str(), path.c_str()) == 0 && move_in(coming, path, (*file)->size());
  if (!kept) remove_all({path, path + ".part"});
  give_way();
  return file;
}

Result<MapCache::File> MapCache::write_named(const std::string& path, const Write& write) try {
  auto file = written(store::open_file(path, O_RDWR | O_CREAT | O_EXCL), write);
  if (!file) ::unlink(path.c_str());
  return file;
} catch (...) {
  ::unlink(path.c_str());
  throw;
}

Result<MapCache::File> MapCache::write_unnamed(const Write& write) {
  return written(Descriptor(open_unnamed_file(settings_.temp_dir)), write);
}

// false: it is larger than the cache, or its job or a mesh was deleted.
bool MapCache::move_in(const Coming& coming, const std::string& path, std::uint64_t bytes) {
  if (bytes > settings_.max_bytes) return false;
  Entry entry{coming.key, coming.meshes, path, bytes};
  Paths removed;
  {
    const std::lock_guard lock(mutex_);
    if (coming.forgotten) return false;
    if (const auto old = by_key_.find(entry.key); old != by_key_.end()) take_out(old->second, removed);
    while (!entries_.empty() && (bytes_ + entry.bytes > settings_.max_bytes || entries_.size() >= kMostFiles)) {
      drop_oldest(removed);
    }
    bytes_ += entry.bytes;
    entries_.push_back(std::move(entry));
    by_key_[entries_.back().key] = std::prev(entries_.end());
  }
  remove_all(removed);
  return true;
}

// Precondition: the lock is held, and there is an entry.
void MapCache::drop_oldest(Paths& removed) {
  ++evictions_;
  take_out(entries_.begin(), removed);
}

// Precondition: the lock is held.
void MapCache::take_out(Entries::iterator at, Paths& removed) {
  removed.push_back(at->path);
  bytes_ -= at->bytes;
  by_key_.erase(at->key);
  entries_.erase(at);
}

template <class Condition>
void MapCache::take_out_if(const Condition& condition) {
  Paths removed;
  {
    const std::lock_guard lock(mutex_);
    for (auto at = entries_.begin(); at != entries_.end();) {
      const auto here = at++;
      if (condition(*here)) take_out(here, removed);
    }
    for (const auto& one : coming_) {
      if (const auto coming = one.lock(); coming && condition(*coming)) coming->forgotten = true;
    }
  }
  remove_all(removed);
}

void MapCache::give_way() {
  const std::lock_guard one(giving_way_);  // two calls would free the room twice
  const std::uint64_t lacking = settings_.lacking ? settings_.lacking() : 0;
  if (lacking == 0) return;
  Paths removed;
  {
    const std::lock_guard lock(mutex_);
    for (const std::uint64_t before = bytes_; !entries_.empty() && before - bytes_ < lacking;) drop_oldest(removed);
  }
  remove_all(removed);
}

void MapCache::forget(const store::JobKey& job) {
  take_out_if([&](const auto& entry) { return entry.key.job == job; });
}

void MapCache::forget_mesh(const std::string& owner, const std::string& id) {
  take_out_if([&](const auto& entry) {
    return entry.key.job.owner == owner &&
           std::find(entry.meshes.begin(), entry.meshes.end(), id) != entry.meshes.end();
  });
}

// Calls `is_there` without the lock, since it may read a disk.
void MapCache::sweep(const std::function<bool(const store::JobKey&)>& is_there) {
  std::vector<store::JobKey> jobs;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, entry] : by_key_) {
      if (jobs.empty() || !(jobs.back() == key.job)) jobs.push_back(key.job);
    }
    for (const auto& one : coming_) {
      if (const auto coming = one.lock()) jobs.push_back(coming->key.job);
    }
  }
  for (const store::JobKey& job : jobs) {
    if (!is_there(job)) forget(job);
  }
}

MapCache::Counters MapCache::counters() const {
  const std::lock_guard lock(mutex_);
  return {bytes_, entries_.size(), evictions_};
}

std::uint64_t lacking_bytes(DiskRoom disk, std::uint64_t wanted) {
  const std::uint64_t least = std::min(wanted, disk.bytes / kKeptFree);
  return least - std::min(disk.free, least);
}

std::uint64_t lacking_bytes_on(const std::string& folder, std::uint64_t wanted) {
  struct statvfs status {};
  if (::statvfs(folder.c_str(), &status) != 0) return 0;
  const std::uint64_t block = status.f_frsize;
  return lacking_bytes({std::uint64_t{status.f_blocks} * block, std::uint64_t{status.f_bavail} * block}, wanted);
}

}  // namespace meshgauge::server
