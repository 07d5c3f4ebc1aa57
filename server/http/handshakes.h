// Handshakes of TLS, paid for by rate: the step that signs with the private key runs on threads of its own, at most so
// many a second for one client address and for all. A recorded hello costs its sender nothing and this step a
// millisecond, so a limit on open connections is none.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/base/threads.h"
#include "server/base/token_bucket.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// A bucket for each client address. Not thread safe; the caller gives the time.
class PeerRates {
 public:
  using Time = TokenBucket::Time;
  // So many seconds' handshakes an address may have at once after a pause.
  static constexpr double kBurstSeconds = 5;
  // Beyond so many addresses new ones share one bucket.
  static constexpr std::size_t kMostPeers = std::size_t{1} << 16;

  explicit PeerRates(std::uint64_t per_second);  // precondition: at least 1

  // Takes one handshake of the address, as peer_of() gives it. Returns how many it has left; nullopt: it had none.
  std::optional<double> take(const std::string& peer, Time now);

  std::size_t size() const { return buckets_.size(); }

 private:
  void forget_full(Time now);

  const double per_second_;
  std::map<std::string, TokenBucket> buckets_;  // an address that is not there has a full one
  Time next_look_ = Time::min();                // for full ones
};

// A handshake that waits for its costly step.
struct Handshake {
  // run: do it now, on this thread; abandoned: the client has gone; refused: others go first.
  enum class Turn { run, abandoned, refused };

  std::uint64_t id = 0;                 // of the connection
  int fd = -1;                          // of its socket
  double left = 0;                      // what its address had left: the address with the most goes first
  std::function<void(Turn)> on_turn{};  // called once, unless the handshake is withdrawn; must not throw
};

// The handshakes that wait, and the bucket of all. Not thread safe; the caller gives the time.
class HandshakeQueue {
 public:
  using Time = TokenBucket::Time;

  // Preconditions: both numbers are at least 1. `most`: how many may wait.
  HandshakeQueue(std::uint64_t per_second, std::size_t most, Time now);

  // Adds one. Where `most` wait already, returns the one that gives way: the oldest of those whose address has the
  // least left, which may be the new one.
  std::optional<Handshake> add(Handshake handshake);

  // Removes the handshake of this connection. False: it does not wait.
  bool remove(std::uint64_t id);

  // Removes the next one: the oldest of those whose address has the most left. nullopt: none waits, or the rate of all
  // allows none before wait() has passed.
  std::optional<Handshake> take(Time now);

  void give_back() { bucket_.give_back(); }  // what a take() took of the rate: its handshake cost nothing
  TokenBucket::Seconds wait() const { return bucket_.wait(); }  // precondition: one waits, and take() gave nullopt
  bool empty() const { return waiting_.empty(); }

 private:
  Handshake removed(std::vector<Handshake>::iterator at);

  const std::size_t most_;
  TokenBucket bucket_;
  std::vector<Handshake> waiting_;  // the oldest first
};

// The threads. Their priority is below that of the event loop, so that open connections go first.
class Handshakes {
 public:
  static constexpr std::size_t kMostWaiting = 256;

  struct Counts {
    std::uint64_t begun = 0;      // the costly step was taken
    std::uint64_t refused = 0;    // for the rate of their address or of all: at once, or in vain until they were late
    std::uint64_t abandoned = 0;  // the client had gone before the costly step
  };

  explicit Handshakes(const Settings& settings);  // precondition: settings come from checked()
  ~Handshakes() = default;                        // blocks until the threads have ended. Precondition: none waits
  Handshakes(const Handshakes&) = delete;
  Handshakes& operator=(const Handshakes&) = delete;

  // Takes one handshake of the address. Returns how many it has left; nullopt: it is refused. Only the event loop's
  // thread may call it.
  std::optional<double> admit(const std::string& peer);

  void abandon() { ++abandoned_; }  // counts a client that had gone before it was admitted. Thread safe

  // Hands a handshake over: its `on_turn` is called on a thread of the pool; or, of the one that has to give way, with
  // `refused` on this thread before this returns. Thread safe.
  void offer(Handshake handshake);

  // Takes the handshake of this connection back, which counts as refused; its `on_turn` will not be called. False: it
  // was, or is being called. Thread safe.
  bool withdraw(std::uint64_t id);

  Counts counts() const { return {begun_.load(), refused_.load(), abandoned_.load()}; }  // thread safe

 private:
  void run();
  void tell_end();

  PeerRates peers_;  // of the event loop's thread
  std::atomic<std::uint64_t> begun_{0}, refused_{0}, abandoned_{0};
  std::mutex mutex_;  // guards what follows
  std::condition_variable ready_;
  HandshakeQueue queue_;
  bool ending_ = false;
  Threads threads_;
};

}  // namespace meshgauge::server
