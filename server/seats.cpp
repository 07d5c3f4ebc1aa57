#include "server/seats.h"

namespace meshgauge::server {

std::shared_ptr<const void> Seats::take(const std::string& owner) {
  struct Seat {
    Seats* seats = nullptr;  // none: not taken
    std::string owner;
    ~Seat() {
      if (seats) seats->give_back(owner);
    }
  };
  const auto seat = std::make_shared<Seat>();
  seat->owner = owner;
  if (!add(owner)) return nullptr;
  seat->seats = this;
  return seat;
}

std::uint64_t Seats::taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

bool Seats::add(const std::string& owner) {
  const std::lock_guard lock(mutex_);
  if (taken_ >= most_) return false;
  const auto found = taken_by_.find(owner);
  const std::uint64_t own = found == taken_by_.end() ? 0 : found->second;
  if (!owner.empty() && own >= (most_ + 1) / 2) return false;
  taken_by_[owner] = own + 1;
  ++taken_;
  return true;
}

void Seats::give_back(const std::string& owner) {
  const std::lock_guard lock(mutex_);
  --taken_;
  const auto found = taken_by_.find(owner);
  if (--found->second == 0) taken_by_.erase(found);
}

}  // namespace meshgauge::server
