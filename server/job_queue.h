// The compute workers: a fixed pool behind a bounded queue, apart from the threads that serve connections.
//
// A slot is taken before a request's body is read and held until its job has run, so that whoever was let in
// is also served: at most workers + queue slots exist.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "engine/control.h"

namespace meshgauge::server {

class JobQueue {
 public:
  class Slot {
   public:
    Slot(Slot&& other) noexcept : queue_(std::exchange(other.queue_, nullptr)) {}
    Slot& operator=(Slot&&) = delete;
    ~Slot();

   private:
    friend class JobQueue;
    explicit Slot(JobQueue* queue) : queue_(queue) {}
    JobQueue* queue_;
  };

  struct Job {
    std::shared_ptr<Control> control;
    // Must not throw. Gives the slot back before it tells anyone its result: who has an answer may come again.
    std::function<void(Slot)> work;
  };

  JobQueue(std::size_t workers, std::size_t queue);
  ~JobQueue();  // runs what was submitted, then ends the workers
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  std::optional<Slot> admit();      // nullopt: full
  void submit(Slot slot, Job job);  // never blocks; jobs start in this order
  struct Load {
    std::size_t waiting = 0;
    std::size_t running = 0;
  };
  Load load() const;
  void cancel_all();  // what runs, waits or is still to be submitted

 private:
  struct Entry {
    Slot slot;
    Job job;
  };

  void work();
  void release();

  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::size_t slots_ = 0;
  std::deque<Entry> waiting_;
  std::vector<Control*> running_;
  bool cancelled_ = false;
  bool ending_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace meshgauge::server
