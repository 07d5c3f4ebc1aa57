// Measures one comparison on the calling thread, from its sources to its stored result; the threads that it borrows,
// and what loads its meshes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <utility>

#include "api/base/problem.h"
#include "api/compare/compare.h"
#include "server/measure/live_job.h"
#include "server/observe/metrics.h"
#include "server/sandbox/memory_budget.h"
#include "server/settings/settings.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

// The threads of idle workers, lent to comparisons that can use more than one. Thread safe.
//
// A comparison keeps its threads until its end, and every later one gets at least the thread of its own worker. So at
// most twice as many threads compute as there are workers.
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

// Loads meshes from their sources. Thread safe.
class MeshLoader {
 public:
  virtual ~MeshLoader() = default;

  // Reserves the memory of the mesh; when that must begin again, the result is meaningless. Errors as of
  // api::compare().
  virtual Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation& memory, Control& control) = 0;
};

// Loads both meshes of a job, which may use `threads`: side by side if reads_side_by_side(), and where a reader process
// and the memory of a second one are free, else b after a. Notes read_a and read_b in `times`. Errors and restarts as
// of MeshLoader::load(), of a before b.
Result<api::SharedMeshes> load_both(MeshLoader& loader, const MeshSource& a, const MeshSource& b, unsigned threads,
                                    MemoryReservation& memory, Control& control, api::StageTimes& times);

// Thread safe. Borrows all but the first.
class Measuring {
 public:
  // `clock`: its time() dates results.
  Measuring(const Settings& settings, MeshLoader& loader, Metrics& metrics, ThreadBudget& threads, MemoryBudget& memory,
            const store::JobStore& clock)
      : settings_(settings), loader_(loader), metrics_(metrics), threads_(threads), memory_(memory), clock_(clock) {}

  // Measures the job. Turns every exception into an Error.
  Result<api::Comparison> measured(LiveJob& job) const;
  void count(LiveJob& job, const Result<api::Comparison>& result) const;
  // Returns the ended job. `stopping`: this process stops.
  JobView last_view(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

 private:
  Result<api::Comparison> measure(LiveJob& job) const;
  Result<api::Comparison> measure_within(MemoryReservation& memory, LiveJob& job, api::StageTimes times) const;
  JobView concluded(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const;

  const Settings settings_;
  MeshLoader& loader_;
  Metrics& metrics_;
  ThreadBudget& threads_;
  MemoryBudget& memory_;
  const store::JobStore& clock_;
};

// Whether Control::cancel() ended the comparison early.
bool stopped_by_cancel(const Result<api::Comparison>& result);

// The problem of a job that was cancelled before it had an interval.
api::Problem cancelled_early();

}  // namespace meshgauge::server
