#include "server/measure/mesh_cache.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <list>
#include <map>
#include <mutex>
#include <utility>

#include "api/compare/load.h"
#include "api/formats/detect.h"
#include "server/base/heap.h"

namespace meshgauge::server {
namespace {

using api::SharedMesh;

constexpr std::chrono::milliseconds kTick{10};
constexpr std::uint64_t kWorthTrimming = std::uint64_t{8} << 20;

// The allocator keeps freed memory; an idle service should return it to the system.
void return_memory(std::uint64_t freed_bytes) {
  static std::atomic<std::uint64_t> freed_since{0};
  if (freed_since.fetch_add(freed_bytes) + freed_bytes < kWorthTrimming) return;
  freed_since = 0;
  release_free_memory();
}

Error damaged(const std::string& id) {
  return {ErrorCode::internal,
          "the stored bytes of mesh " + id + " are damaged: their SHA-256 is another one; store the mesh again", "",
          ""};
}

}  // namespace

class MeshCache::Shelf : public std::enable_shared_from_this<MeshCache::Shelf> {
 public:
  explicit Shelf(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  Result<SharedMesh> get(const Key& key, const Load& load, Control& control);
  void forget(const std::string& owner, const std::string& id);
  Counters counters() const;

 private:
  struct Entry;
  using Entries = std::map<Key, std::shared_ptr<Entry>>;
  using Place = Entries::iterator;

  struct Entry {
    SharedMesh mesh;  // null: being loaded
    std::uint64_t bytes = 0;
    std::size_t users = 0;
    bool kept = true;                  // whether it is in entries_; else its uses alone hold it
    std::list<Place>::iterator place;  // if kept: in idle_ while it has a mesh and no use, else in busy_
  };

  // Meshes that are dropped under the lock are destroyed after it, because that takes a while. Does not throw:
  // destructors call it.
  struct Dropped {
    Dropped() = default;
    Dropped(const Dropped&) = delete;
    Dropped& operator=(const Dropped&) = delete;
    ~Dropped() {
      entries.clear();
      last_use.reset();
      if (bytes > 0) return_memory(bytes);
    }

    Entries entries;
    std::shared_ptr<Entry> last_use;
    std::uint64_t bytes = 0;
  };

  class Loading;
  struct Loan;

  SharedMesh lend(Place at);
  void give_back(std::shared_ptr<Entry> entry);
  void count_anew(Entry& entry);
  void make_room(Dropped& dropped);
  void evict(Place at, Dropped& dropped);
  void remove(Place at, Dropped& dropped);

  const std::uint64_t max_bytes_;
  mutable std::mutex mutex_;  // guards the members below, and all entries
  std::condition_variable changed_;
  Entries entries_;
  std::list<Place> busy_;
  std::list<Place> idle_;  // the longest unused first
  std::uint64_t bytes_ = 0;
  Counters counters_;
};

// One use of a mesh.
struct MeshCache::Shelf::Loan {
  Loan(std::shared_ptr<Shelf> from, std::shared_ptr<Entry> lent) : shelf(std::move(from)), entry(std::move(lent)) {}
  Loan(const Loan&) = delete;
  Loan& operator=(const Loan&) = delete;
  ~Loan() { shelf->give_back(std::move(entry)); }

  const std::shared_ptr<Shelf> shelf;
  std::shared_ptr<Entry> entry;
};

// The right to load a mesh. Without keep(), also when loading throws, its destructor frees the place.
class MeshCache::Shelf::Loading {
 public:
  // Precondition: the lock is held; for the other functions it is not.
  Loading(Shelf& shelf, Place at) : shelf_(shelf), at_(at), entry_(at->second) {}
  Loading(const Loading&) = delete;
  Loading& operator=(const Loading&) = delete;
  ~Loading() {
    const std::lock_guard lock(shelf_.mutex_);
    if (!entry_->mesh && entry_->kept) {
      shelf_.busy_.erase(entry_->place);
      shelf_.entries_.erase(at_);
    }
    shelf_.changed_.notify_all();
  }

  SharedMesh keep(const SharedMesh& mesh) {
    Dropped dropped;
    const std::lock_guard lock(shelf_.mutex_);
    const bool forgotten = !entry_->kept;  // meanwhile
    if (forgotten || mesh->bytes() > shelf_.max_bytes_) return mesh;
    entry_->mesh = mesh;
    shelf_.count_anew(*entry_);
    shelf_.idle_.splice(shelf_.idle_.end(), shelf_.busy_, entry_->place);
    SharedMesh lent = shelf_.lend(at_);
    shelf_.make_room(dropped);
    return lent;
  }

 private:
  Shelf& shelf_;
  const Place at_;
  const std::shared_ptr<Entry> entry_;
};

Result<SharedMesh> MeshCache::Shelf::get(const Key& key, const Load& load, Control& control) {
  std::unique_lock lock(mutex_);
  auto found = entries_.find(key);
  while (found != entries_.end() && !found->second->mesh) {
    if (const Interruption why = control.check(); why != Interruption::none) {
      return api::not_in_time(why, "the mesh was read");
    }
    changed_.wait_for(lock, kTick);
    found = entries_.find(key);
  }
  if (found != entries_.end()) {
    ++counters_.hits;
    return lend(found);
  }
  const auto entry = std::make_shared<Entry>();
  std::list<Place> place(1);
  place.front() = found = entries_.emplace(key, entry).first;
  entry->place = place.begin();
  busy_.splice(busy_.end(), place);
  ++counters_.misses;
  Loading loading(*this, found);
  lock.unlock();
  auto mesh = load(control);
  if (!mesh) return mesh;
  if ((*mesh)->facts.sha256 != key.id) return damaged(key.id);
  return loading.keep(*mesh);
}

// Precondition: the lock is held, and the entry has a mesh.
SharedMesh MeshCache::Shelf::lend(Place at) {
  const std::shared_ptr<Entry> entry = at->second;
  const auto loan = std::make_shared<Loan>(shared_from_this(), entry);
  if (entry->users++ == 0) busy_.splice(busy_.end(), idle_, entry->place);
  return {loan, entry->mesh.get()};
}

void MeshCache::Shelf::give_back(std::shared_ptr<Entry> entry) {
  Dropped dropped;
  const std::lock_guard lock(mutex_);
  --entry->users;
  if (entry->kept) {
    count_anew(*entry);
    if (entry->users == 0) idle_.splice(idle_.end(), busy_, entry->place);
    if (entry->bytes > max_bytes_) evict(*entry->place, dropped);  // evicting others for it would be in vain
    make_room(dropped);
  } else if (entry->users == 0) {
    dropped.bytes = entry->mesh->bytes();
  }
  dropped.last_use = std::move(entry);
}

void MeshCache::Shelf::count_anew(Entry& entry) {
  bytes_ -= entry.bytes;
  entry.bytes = entry.mesh->bytes();
  bytes_ += entry.bytes;
}

void MeshCache::Shelf::make_room(Dropped& dropped) {
  while (bytes_ > max_bytes_ && !idle_.empty()) evict(idle_.front(), dropped);
}

void MeshCache::Shelf::evict(Place at, Dropped& dropped) {
  ++counters_.evictions;
  remove(at, dropped);
}

void MeshCache::Shelf::remove(Place at, Dropped& dropped) {
  Entry& entry = *at->second;
  auto& list = entry.mesh && entry.users == 0 ? idle_ : busy_;
  list.erase(entry.place);
  entry.kept = false;
  bytes_ -= entry.bytes;
  if (&list == &idle_) dropped.bytes += entry.bytes;
  dropped.entries.insert(entries_.extract(at));
}

void MeshCache::Shelf::forget(const std::string& owner, const std::string& id) {
  Dropped dropped;
  const std::lock_guard lock(mutex_);
  auto at = entries_.lower_bound({owner, id, std::nullopt, std::nullopt});
  while (at != entries_.end() && at->first.owner == owner && at->first.id == id) remove(at++, dropped);
}

MeshCache::Counters MeshCache::Shelf::counters() const {
  const std::lock_guard lock(mutex_);
  Counters counters = counters_;
  counters.bytes = bytes_;
  counters.meshes = entries_.size();
  counters.in_use = busy_.size();
  return counters;
}

MeshCache::Key MeshCache::key(std::string owner, std::string id, std::string_view filename,
                              std::string_view media_type) {
  return {std::move(owner), std::move(id), api::format_by_name(filename), api::format_by_media_type(media_type)};
}

MeshCache::MeshCache(std::uint64_t max_bytes) : shelf_(std::make_shared<Shelf>(max_bytes)) {}

Result<SharedMesh> MeshCache::get(const Key& key, const Load& load, Control& control) {
  return shelf_->get(key, load, control);
}

void MeshCache::forget(const std::string& owner, const std::string& id) { shelf_->forget(owner, id); }

MeshCache::Counters MeshCache::counters() const { return shelf_->counters(); }

}  // namespace meshgauge::server
