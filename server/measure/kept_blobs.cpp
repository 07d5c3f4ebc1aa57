#include "server/measure/kept_blobs.h"

#include <chrono>
#include <optional>
#include <utility>

namespace meshgauge::server {
namespace {

constexpr std::chrono::seconds kRemoving{1};
constexpr std::size_t kMostUnneeded = 10'000;

}  // namespace

Result<std::uint64_t> bytes_of(const Stores& stores, const std::string& owner) {
  const auto files = stores.blobs.stored_bytes(owner);
  if (!files) return files.error();
  const auto rows = stores.meshes.stored(owner);
  if (!rows) return rows.error();
  return *files + rows->meshes * kMeshOverhead;
}

std::variant<StorageHold, Denial> hold_storage(Access& access, const Stores& stores, const std::string& owner,
                                               std::uint64_t bytes, std::uint64_t max_stored_bytes) {
  if (bytes == 0) return StorageHold();
  std::optional<Error> failure;
  auto hold = access.hold_storage(owner, bytes, max_stored_bytes, [&]() -> std::uint64_t {
    const auto stored = bytes_of(stores, owner);
    if (!stored) failure = stored.error();
    return stored ? *stored : 0;
  });
  if (failure) return Denial{api::to_problem(*failure)};
  return hold;
}

Result<bool> remove_if_unreferenced(const Stores& stores, const store::BlobKey& key) {
  return stores.blobs.remove_unreferenced(key, [&] { return stores.jobs.uses_blob(key); });
}

void release_blobs(const Stores& stores, StoreErrors& store_errors, const std::string& owner, const std::string& a,
                   const std::string& b) {
  if (stores.shared) return;
  for (const std::string& id : {a, b}) store_errors.note(remove_if_unreferenced(stores, {owner, id}));
}

void UnneededBlobs::add(store::BlobKey key) {
  const std::lock_guard lock(mutex_);
  keys_.push_back(std::move(key));
  if (keys_.size() > kMostUnneeded) keys_.pop_front();
}

// A sweep removes the keys that overflow the queue, and those that are dropped when the store does not answer.
void UnneededBlobs::remove_some() {
  const auto until = std::chrono::steady_clock::now() + kRemoving;
  while (std::chrono::steady_clock::now() < until) {
    store::BlobKey key;
    {
      const std::lock_guard lock(mutex_);
      if (keys_.empty()) return;
      key = std::move(keys_.front());
      keys_.pop_front();
    }
    const auto removed = store_errors_.noted(remove_if_unreferenced(stores_, key));
    if (removed) continue;
    const std::lock_guard lock(mutex_);
    return keys_.clear();
  }
}

}  // namespace meshgauge::server
