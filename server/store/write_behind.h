// What a store promises to write, but not at once: ended jobs, and times at which meshes were used. A thread gathers
// them and writes them in batches; while nothing can be written they are held, and tried again. Thread safe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
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

class WriteBehind {
 public:
  using Touches = std::unordered_map<BlobKey, Touch, KeyHash>;
  struct Batch {
    std::vector<std::shared_ptr<const Job>> jobs;
    Touches touches;
  };
  // Writes a batch durably, or (an Error) nothing of it. Called by one thread at a time.
  using Write = std::function<Result<Done>(const Batch&)>;

  // `max_jobs`: held at most; beyond that the oldest is dropped.
  WriteBehind(std::size_t max_jobs, Write write);
  ~WriteBehind();  // after what it was given is written, if it can be
  WriteBehind(const WriteBehind&) = delete;
  WriteBehind& operator=(const WriteBehind&) = delete;

  void record(Job ended);
  void touch(const BlobKey& mesh, Touch touch);
  // Until all that was given before is durable; the error that kept it from that.
  Result<Done> flush();

  std::shared_ptr<const Job> find(const JobKey& key) const;  // null: not given, or written
  void add_to(Counts& counts) const;

 private:
  void write_in_background();
  Result<Done> write_some();
  void take();
  void end(const Result<Done>& written);
  void drop_beyond_maximum();

  const std::size_t max_jobs_;
  const Write write_;
  mutable std::mutex mutex_;  // guards what follows, but batch_
  std::condition_variable changed_;
  bool stopped_ = false;
  std::deque<std::shared_ptr<const Job>> waiting_;
  Touches touches_;
  std::unordered_map<JobKey, std::shared_ptr<const Job>, KeyHash> by_key_;
  std::uint64_t dropped_ = 0;
  std::mutex writing_;  // held by the thread that writes
  Batch batch_;
  std::thread thread_;
};

}  // namespace meshgauge::server::store
