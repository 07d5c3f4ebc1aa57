#include "server/http/handshakes.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/base/heap.h"
#include "server/http/transport.h"

namespace meshgauge::server {
namespace {

constexpr std::size_t kFewPeers = 1024;                  // so many are not looked through for full buckets
constexpr auto kBetweenLooks = std::chrono::seconds(1);  // kMostPeers buckets take some milliseconds
constexpr double kBurstOfAllSeconds = 0.25;              // so many seconds' handshakes may come at once after a pause
constexpr int kHandshakeNiceness = 5;                    // after the event loop (0), before comparisons (10)

double burst_of(std::uint64_t per_second, double seconds) {
  return std::max(1.0, static_cast<double>(per_second) * seconds);
}

}  // namespace

PeerRates::PeerRates(std::uint64_t per_second) : per_second_(static_cast<double>(per_second)) {}

std::optional<double> PeerRates::take(const std::string& peer, Time now) {
  auto found = buckets_.find(peer);
  if (found == buckets_.end()) {
    forget_full(now);
    const std::string key = buckets_.size() < kMostPeers ? peer : std::string();
    found = buckets_.try_emplace(key, per_second_, kBurstSeconds * per_second_, now).first;
  }
  if (!found->second.take(now)) return std::nullopt;
  return found->second.level();
}

void PeerRates::forget_full(Time now) {
  if (buckets_.size() < kFewPeers || now < next_look_) return;
  next_look_ = now + kBetweenLooks;
  std::erase_if(buckets_, [now](const auto& entry) { return entry.second.is_full(now); });
}

HandshakeQueue::HandshakeQueue(std::uint64_t per_second, std::size_t most, Time now)
    : most_(most), bucket_(static_cast<double>(per_second), burst_of(per_second, kBurstOfAllSeconds), now) {}

Handshake HandshakeQueue::removed(std::vector<Handshake>::iterator at) {
  Handshake handshake = std::move(*at);
  waiting_.erase(at);
  return handshake;
}

std::optional<Handshake> HandshakeQueue::add(Handshake handshake) {
  waiting_.push_back(std::move(handshake));
  if (waiting_.size() <= most_) return std::nullopt;
  return removed(std::min_element(waiting_.begin(), waiting_.end(),
                                  [](const Handshake& a, const Handshake& b) { return a.left < b.left; }));
}

bool HandshakeQueue::remove(std::uint64_t id) {
  return std::erase_if(waiting_, [id](const Handshake& handshake) { return handshake.id == id; }) > 0;
}

std::optional<Handshake> HandshakeQueue::take(Time now) {
  if (waiting_.empty() || !bucket_.take(now)) return std::nullopt;
  return removed(std::max_element(waiting_.begin(), waiting_.end(),
                                  [](const Handshake& a, const Handshake& b) { return a.left < b.left; }));
}

Handshakes::Handshakes(const Settings& settings)
    : peers_(settings.max_handshakes_per_second_per_peer),
      queue_(settings.max_handshakes_per_second, kMostWaiting, TokenBucket::Time::clock::now()),
      threads_([this] { tell_end(); }) {
  for (std::uint64_t i = 0; i < settings.handshake_threads; ++i) threads_.start([this] { run(); });
}

void Handshakes::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ready_.notify_all();
}

std::optional<double> Handshakes::admit(const std::string& peer) {
  const auto left = peers_.take(peer, TokenBucket::Time::clock::now());
  if (!left) ++refused_;
  return left;
}

void Handshakes::offer(Handshake handshake) {
  std::optional<Handshake> refused;
  {
    const std::lock_guard lock(mutex_);
    refused = queue_.add(std::move(handshake));
  }
  ready_.notify_one();
  if (!refused) return;
  ++refused_;
  const NeverFails waits_for_memory;  // the handshake that was offered is not the caller's any more
  refused->on_turn(Handshake::Turn::refused);
}

bool Handshakes::withdraw(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  const bool waited = queue_.remove(id);
  if (waited) ++refused_;
  return waited;
}

void Handshakes::run() {
  const NeverFails waits_for_memory;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kHandshakeNiceness);
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (auto next = queue_.take(TokenBucket::Time::clock::now())) {
      lock.unlock();
      const bool gone = peer_hung_up(next->fd);
      ++(gone ? abandoned_ : begun_);
      next->on_turn(gone ? Handshake::Turn::abandoned : Handshake::Turn::run);
      next.reset();
      lock.lock();
      if (gone) queue_.give_back();
    } else if (queue_.empty()) {
      ready_.wait(lock);
    } else {
      ready_.wait_for(lock, std::chrono::ceil<std::chrono::microseconds>(queue_.wait()));
    }
  }
}

}  // namespace meshgauge::server
