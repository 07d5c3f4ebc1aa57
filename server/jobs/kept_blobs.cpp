#include "server/jobs/kept_blobs.h"

#include <optional>

namespace meshgauge::server {

std::variant<StorageHold, Denial> hold_storage(Access& access, store::BlobStore& blobs, const std::string& owner,
                                               std::uint64_t bytes, std::uint64_t max_stored_bytes) {
  if (bytes == 0) return StorageHold();
  std::optional<Error> failure;
  auto hold = access.hold_storage(owner, bytes, max_stored_bytes, [&]() -> std::uint64_t {
    const auto stored = blobs.stored_bytes(owner);
    if (stored) return *stored;
    failure = stored.error();
    return 0;
  });
  if (failure) return Denial{api::to_problem(*failure), {}};
  return hold;
}

Result<bool> remove_if_unreferenced(const Stores& stores, const store::BlobKey& key) {
  return stores.blobs.remove_unreferenced(key, [&] { return stores.jobs.uses_blob(key); });
}

void release_blobs(const Stores& stores, Troubles& troubles, const std::string& owner, const std::string& a,
                   const std::string& b) {
  if (stores.shared()) return;
  for (const std::string& id : {a, b}) troubles.note(remove_if_unreferenced(stores, {owner, id}));
}

}  // namespace meshgauge::server
