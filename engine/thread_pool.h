// The threads of one job: the caller's and its helpers.
//
// Plain threads and an atomic counter, so that ThreadSanitizer sees every hand-over (it cannot look into a prebuilt
// scheduler). Tasks are taken one by one by whoever is free.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace meshgauge {

class ThreadPool {
 public:
  // `size` >= 1 threads, the caller's included. Helpers are started by the first run() that needs
  // them; where the system refuses, there are fewer.
  explicit ThreadPool(std::size_t size) : size_(size) {}
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  std::size_t size() const { return size_; }

  // Calls work(worker, task) once for each task in [0, tasks), worker < size(), no two at a time with the same worker.
  // In order with one thread, in any order otherwise. Returns when all are done. What one throws is thrown here, after
  // the tasks that had begun are done; the rest is then left out. Only the thread that made the pool may call this.
  void run(std::size_t tasks, const std::function<void(std::size_t worker, std::size_t task)>& work);

 private:
  void start_helpers(std::size_t count);
  void help(std::size_t worker, std::size_t seen);
  void take_tasks(std::size_t worker);

  const std::size_t size_;
  std::vector<std::thread> helpers_;

  std::mutex mutex_;
  std::condition_variable begin_;
  std::condition_variable end_;
  std::size_t round_ = 0;  // how many runs have been begun
  std::size_t busy_ = 0;   // helpers that have not finished this one
  bool leave_ = false;
  std::exception_ptr error_;

  const std::function<void(std::size_t, std::size_t)>* work_ = nullptr;
  std::size_t tasks_ = 0;
  std::atomic<std::size_t> next_{0};
};

}  // namespace meshgauge
