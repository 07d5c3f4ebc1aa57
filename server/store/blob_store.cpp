#include "server/store/blob_store.h"

#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>

#include "server/store/data_folder.h"
#include "server/store/remote_blobs.h"

namespace meshgauge::server::store {

Blob::~Blob() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Result<Blob> Blob::map(Descriptor file) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return storage_error(errno, "the stored mesh cannot be read");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return Blob(std::move(file), {});
  const void* start = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (start == MAP_FAILED) return storage_error(errno, "the stored mesh cannot be read");
  return Blob(std::move(file), {static_cast<const std::byte*>(start), size});
}

Reservations::Held::Held(Reservations& all, const BlobKey& key) : all_(all), name_(blob_name(key)) {
  all_.begin(name_);
}

Reservations::Held::~Held() { all_.end(name_); }

void Reservations::begin(const std::string& name) {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [&] { return !closed_.contains(name); });
  held_.insert(name);
}

void Reservations::end(const std::string& name) {
  const std::lock_guard lock(mutex_);
  held_.erase(held_.find(name));
}

Result<bool> Reservations::unless_held(const std::string& name, const std::function<Result<bool>()>& work) {
  // Reopened also when work() throws.
  struct Closed {
    Reservations& all;
    const std::string& name;
    bool entered;
    ~Closed() {
      if (!entered) return;
      {
        const std::lock_guard lock(all.mutex_);
        all.closed_.erase(name);
      }
      all.done_.notify_all();
    }
  };
  std::unique_lock lock(mutex_);
  done_.wait(lock, [&] { return !closed_.contains(name); });
  if (held_.contains(name)) return false;
  const Closed closed{*this, name, closed_.insert(name).second};
  lock.unlock();
  return work();
}

Result<bool> BlobStore::remove_unreferenced(const BlobKey& key, const std::function<Result<bool>()>& referenced) {
  return reservations_->unless_held(blob_name(key), [&]() -> Result<bool> {
    Result<bool> is = referenced();
    if (!is || *is) return is ? Result<bool>(false) : is;
    return remove(key);
  });
}

}  // namespace meshgauge::server::store
