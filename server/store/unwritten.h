// What the store has promised to write, but not at once: ended jobs, and times at which meshes were used. Thread safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/store/mesh_index.h"

namespace meshgauge::server::store {

struct Touch {
  TimePoint last_used;
  TimePoint expires;
};

struct KeyHash {
  template <class Key>
  std::size_t operator()(const Key& key) const {
    const std::hash<std::string> hash;
    return hash(key.id) ^ (hash(key.owner) << 1);
  }
};

class Unwritten {
 public:
  using Touches = std::unordered_map<BlobKey, Touch, KeyHash>;
  struct Batch {
    std::vector<std::shared_ptr<const Job>> jobs;
    Touches touches;
    bool empty() const { return jobs.empty() && touches.empty(); }
  };

  explicit Unwritten(std::size_t max_jobs) : max_jobs_(max_jobs) {}

  void add(Job job);  // beyond the maximum the oldest is dropped
  void add(const BlobKey& mesh, Touch touch);
  std::shared_ptr<const Job> find(const JobKey& key) const;  // until it is settled

  // Blocks until there is something, and then as long as `linger` for more to come. false: stop() was called.
  bool wait(std::chrono::milliseconds linger);
  void pause(std::chrono::milliseconds time);  // or until stop()
  void stop();

  // The oldest, one batch at a time: one of the three others is called before the next. By one thread at a time.
  const Batch& take();
  void settle();                          // the batch is durable
  void put_back();                        // it could not be written: later again
  void give_up();                         // it can never be written
  void end(const Result<Done>& written);  // one of these, by what came of writing it

  std::uint64_t jobs() const;     // that wait or are in the batch
  std::uint64_t dropped() const;  // jobs, so far
  static constexpr std::size_t kBatch = 1000;

 private:
  void forget_batch();
  void drop_beyond_maximum();

  const std::size_t max_jobs_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stopped_ = false;
  std::deque<std::shared_ptr<const Job>> waiting_;
  Touches touches_;
  Batch batch_;
  std::unordered_map<JobKey, std::shared_ptr<const Job>, KeyHash> by_key_;
  std::uint64_t dropped_ = 0;
};

}  // namespace meshgauge::server::store
