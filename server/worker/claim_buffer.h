// The jobs that a worker has claimed and not begun: in which order they begin, and how many more to claim.
//
// Jobs of no batch first, since somebody may be waiting for each; then those of batches; either in the order in which
// they came. One that is suspected waits until nothing runs, and nothing begins beside it: if it ends its worker, it
// takes nobody with it. What was claimed before it goes on beginning, and nothing is claimed before it is over.
//
// A job in stock is one that no other worker can run. So there is a stock only of small jobs of batches, whose runs may
// be shorter than a claim, and of no more than the others could do in about a second.
//
// Not thread safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <vector>

#include "server/worker/held_job.h"

namespace meshgauge::server {

class ClaimBuffer {
 public:
  static constexpr std::size_t kMost = 64;
  static constexpr std::size_t kRefillBelow = 32;
  static constexpr std::uint64_t kMostBytes = static_cast<std::uint64_t>(store::JobStore::kBytesOfOneSecond) / 2;
  static constexpr std::uint64_t kSmallBytes = std::uint64_t{4} << 20;

  explicit ClaimBuffer(std::size_t threads) : threads_(threads) {}

  void add(HeldJobPtr job);
  // The next one that begins now: it counts as running until ended(). null: none, or none yet.
  HeldJobPtr take();
  void ended(const HeldJob& job);
  void remove(const HeldJob& job);  // of those that were not taken
  std::vector<HeldJobPtr> take_all();

  // How many to ask the store for; 0: none.
  std::size_t wanted() const;

  // The first whose meshes are to be looked up at `now`; null: none.
  HeldJobPtr to_open(LiveJob::Clock::time_point now) const;
  // When there will be one that waits for a second look.
  std::optional<LiveJob::Clock::time_point> next_opening() const;

  std::size_t waiting() const { return waiting_.size(); }
  std::size_t running() const { return running_; }

 private:
  bool is_small(const HeldJob& job) const { return job.in_batch && job.live->bytes <= kSmallBytes; }

  const std::size_t threads_;
  std::list<HeldJobPtr> waiting_;
  std::uint64_t waiting_bytes_ = 0;
  std::size_t running_ = 0;
  std::size_t large_running_ = 0;
  std::size_t suspected_ = 0;  // that wait or run
  bool alone_ = false;         // one of them runs
};

}  // namespace meshgauge::server
