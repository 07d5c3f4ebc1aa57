// The threads of idle workers, lent to comparisons that can use more than one. Thread safe.
//
// A comparison keeps its threads until its end, and every later one gets at least the thread of its own worker. So at
// most twice as many threads compute as there are workers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <utility>

namespace meshgauge::server {

class ThreadBudget {
 public:
  // Bytes of both files, about 20,000 triangles each: larger ones get more threads than one.
  static constexpr std::uint64_t kWorthThreads = std::uint64_t{2} << 20;

  class Loan {
   public:
    Loan(Loan&& other) noexcept : budget_(std::exchange(other.budget_, nullptr)), threads_(other.threads_) {}
    Loan& operator=(Loan&&) = delete;
    ~Loan() {
      if (budget_) budget_->take_back(threads_);
    }

    unsigned threads() const { return threads_; }

   private:
    friend class ThreadBudget;
    Loan(ThreadBudget* budget, unsigned threads) : budget_(budget), threads_(threads) {}
    ThreadBudget* budget_;
    unsigned threads_;
  };

  explicit ThreadBudget(std::uint64_t workers) : workers_(workers) {}

  // Lends at least 1 thread, at most `asked` and at most what is not lent. For a worker that begins a job.
  Loan lend(unsigned asked) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t idle = workers_ - std::min(workers_, lent_);
    const auto threads = static_cast<unsigned>(std::max<std::uint64_t>(1, std::min<std::uint64_t>(asked, idle)));
    lent_ += threads;
    return {this, threads};
  }

 private:
  void take_back(unsigned threads) {
    const std::lock_guard lock(mutex_);
    lent_ -= threads;
  }

  const std::uint64_t workers_;
  std::mutex mutex_;
  std::uint64_t lent_ = 0;
};

}  // namespace meshgauge::server
