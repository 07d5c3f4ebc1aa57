// A thread pool for one job: the thread that owns it and its helpers. Each thread takes one task at a time.
//
// It uses plain threads and an atomic counter, so that ThreadSanitizer sees every hand-over, which it cannot in a
// prebuilt scheduler.
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
  // `size` >= 1 is the number of threads, the owner's included. The first run() that needs helpers starts them. If the
  // system refuses threads, there are fewer.
  explicit ThreadPool(std::size_t size) : size_(size) {}
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  std::size_t size() const { return size_; }

  // Calls work(worker, task) once for each task in [0, tasks), with worker < size() and never two calls at a time with
  // the same worker; in ascending order with one thread, in any order with more. Blocks until all are done. If a task
  // throws, no further task begins, and its exception is thrown here when the running ones have ended. Only the thread
  // that made the pool may call this.
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
  std::size_t round_ = 0;  // number of runs begun
  std::size_t busy_ = 0;   // helpers that have not finished the current run
  bool leave_ = false;
  std::exception_ptr error_;

  const std::function<void(std::size_t, std::size_t)>* work_ = nullptr;
  std::size_t tasks_ = 0;
  std::atomic<std::size_t> next_{0};
};

}  // namespace meshgauge
