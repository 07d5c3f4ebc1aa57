// Writes ended jobs, and the times at which meshes were used, a little later: a thread gathers and writes them in
// batches. While nothing can be written they are held, and tried again. Thread safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/base/threads.h"
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

class WriteBehind {
 public:
  using Touches = std::unordered_map<BlobKey, Touch, KeyHash>;
  struct Batch {
    std::vector<std::shared_ptr<const Job>> jobs;
    Touches touches;
  };
  // Writes a batch durably, or on an error nothing of it. Called by one thread at a time.
  using Write = std::function<Result<Done>(const Batch&)>;

  // `max_jobs`: the most that are held; beyond that the oldest is dropped.
  WriteBehind(std::size_t max_jobs, Write write);
  ~WriteBehind();  // writes what is held, if it can be written
  WriteBehind(const WriteBehind&) = delete;
  WriteBehind& operator=(const WriteBehind&) = delete;

  void record(Job ended);
  void touch(const BlobKey& mesh, Touch touch);
  // Blocks until all that was given before is durable, or returns the error that prevents it.
  Result<Done> flush();

  std::shared_ptr<const Job> find(const JobKey& key) const;  // null: not held
  // Forgets a record that is held. Waits for a batch that is being written. false: it was not held, or just written.
  bool drop(const JobKey& key);
  Touches touches() const;  // those that are held
  void add_to(Counts& counts) const;

 private:
  void write_in_background();
  void tell_end();
  Result<Done> write_some();
  void take();
  void end(const Result<Done>& written);
  void drop_beyond_maximum();

  const std::size_t max_jobs_;
  const Write write_;
  mutable std::mutex mutex_;  // guards the members below, except batch_
  std::condition_variable changed_;
  bool stopped_ = false;
  std::deque<std::shared_ptr<const Job>> waiting_;
  Touches touches_;
  std::unordered_map<JobKey, std::shared_ptr<const Job>, KeyHash> by_key_;
  std::uint64_t dropped_ = 0;
  std::mutex writing_;  // held by the thread that writes
  Batch batch_;
  Threads threads_;
};

}  // namespace meshgauge::server::store
