#include "server/store/blob_store.h"

#include <algorithm>

namespace meshgauge::server::store {

Reservations::Held::Held(Reservations& all, BlobKey key) : all_(all), key_(std::move(key)) {
  const std::lock_guard lock(all_.mutex_);
  all_.held_.push_back(key_);
}

Reservations::Held::~Held() {
  const std::lock_guard lock(all_.mutex_);
  all_.held_.erase(std::find(all_.held_.begin(), all_.held_.end(), key_));
}

Result<bool> Reservations::unless_held(const BlobKey& key, const std::function<Result<bool>()>& work) {
  const std::lock_guard lock(mutex_);
  if (std::find(held_.begin(), held_.end(), key) != held_.end()) return false;
  return work();
}

Result<bool> BlobStore::remove_unreferenced(const BlobKey& key, const std::function<Result<bool>()>& referenced) {
  return reservations_.unless_held(key, [&]() -> Result<bool> {
    Result<bool> is = referenced();
    if (!is || *is) return is ? Result<bool>(false) : is;
    return remove(key);
  });
}

}  // namespace meshgauge::server::store
