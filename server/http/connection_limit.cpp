#include "server/http/connection_limit.h"

namespace meshgauge::server {

std::shared_ptr<const void> ConnectionLimit::take(const std::string& key) {
  struct Place {
    ConnectionLimit* limit = nullptr;  // null: not taken
    std::string key;
    ~Place() {
      if (limit) limit->give_back(key);
    }
  };
  const auto place = std::make_shared<Place>();
  place->key = key;
  if (!add(key)) return nullptr;
  place->limit = this;
  return place;
}

std::uint64_t ConnectionLimit::taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

bool ConnectionLimit::add(const std::string& key) {
  const std::lock_guard lock(mutex_);
  if (taken_ >= max_total_) return false;
  const auto found = taken_by_.find(key);
  const std::uint64_t own = found == taken_by_.end() ? 0 : found->second;
  if (!key.empty() && own >= max_per_key_) return false;
  taken_by_[key] = own + 1;
  ++taken_;
  return true;
}

void ConnectionLimit::give_back(const std::string& key) {
  const std::lock_guard lock(mutex_);
  --taken_;
  const auto found = taken_by_.find(key);
  if (--found->second == 0) taken_by_.erase(found);
}

}  // namespace meshgauge::server
