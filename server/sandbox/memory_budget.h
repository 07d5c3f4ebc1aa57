// The memory that comparisons and deviation maps may take together, reserved before it is taken.
//
// A job reserves step by step, as it learns what it needs: for the process that reads a file, and for each mesh once
// its reader has counted it. A step that does not fit fails: the job gives everything back, waits in order for all that
// it knows it needs, and begins again. So a job never waits while it holds memory, and no two jobs wait for each other.
// The memory of searches is set aside for each thread (plan_memory(), server/settings/settings.h).
//
// A second file that a job reads beside its first has a reservation of its own, which the job takes over in the end. It
// takes nothing of the last quarter of the budget or before a job that waits, and never waits itself: where a step does
// not fit, or no process is free, the file is read after the first. Where it leaves too little for a step of the first,
// the job begins again, and reads one file after the other.
//
// Order: the job that waits longest is next. Small jobs pass large ones that wait, within an eighth of the budget that
// large jobs never get, unless they became large by a second file; so a large job neither blocks small ones nor is kept
// waiting by them.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <mutex>
#include <utility>
#include <vector>

#include "engine/control.h"
#include "engine/result.h"
#include "server/sandbox/reading.h"

namespace meshgauge::server {

// Thread safe. Must outlive its reservations.
class MemoryBudget {
 public:
  static constexpr std::uint64_t kForSmall = 8;   // an eighth of the budget is for small jobs alone
  static constexpr std::uint64_t kSmallest = 16;  // a small job takes at most a 16th of the budget
  static constexpr std::uint64_t kForFirst = 4;   // a quarter of the budget is not for second files

  explicit MemoryBudget(std::uint64_t bytes) : bytes_(bytes) {}

  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t most_of_a_job() const { return bytes_ - bytes_ / kForSmall; }  // what one job can ever get
  std::uint64_t reserved() const;

 private:
  friend class MemoryReservation;
  using Waiting = std::list<std::uint64_t>;  // bytes

  bool is_small(std::uint64_t bytes) const { return bytes <= bytes_ / kSmallest; }
  bool change(std::uint64_t held, std::uint64_t bytes, bool of_second = false);
  void join(std::uint64_t held, std::uint64_t other);
  Interruption wait(std::uint64_t bytes, Control& control);
  bool fits(std::uint64_t held, std::uint64_t bytes) const;
  bool is_behind(std::uint64_t bytes, Waiting::const_iterator end) const;
  void count(std::uint64_t held, std::uint64_t bytes);

  const std::uint64_t bytes_;
  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable freed_;
  std::uint64_t reserved_ = 0;
  std::uint64_t of_small_ = 0;  // of that: by small jobs
  Waiting waiting_;             // in the order of their coming
};

// What one job has reserved. For one thread. Gives it back when it is destroyed.
class MemoryReservation final : public sandbox::Memory {
 public:
  explicit MemoryReservation(MemoryBudget& budget) : budget_(budget) {}
  // For the second file of the job whose first file `first` is for: of the same budget, and without begin().
  explicit MemoryReservation(const MemoryReservation* first) : budget_(first->budget_), of_second_(true) {}
  MemoryReservation(const MemoryReservation&) = delete;
  MemoryReservation& operator=(const MemoryReservation&) = delete;
  ~MemoryReservation() override;

  // Waits until all that the job is known to need is free, at first nothing. Call it before each attempt. Errors:
  // out_of_time when `control` says to stop.
  Result<Done> begin(Control& control);

  // Each reserves a step, or fails: with too_large when the job can never have so much; else restart() is true. For a
  // second file restart() is true whenever one fails.
  Result<Done> wait_for_turn() override;
  Result<std::uint64_t> take_reader(std::uint64_t bytes) override;
  Result<Done> take_mesh(std::uint64_t vertices, std::uint64_t triangles) override;
  void end_reader() override;
  Result<Done> take_more(std::uint64_t bytes);  // beside the meshes, when all have been read
  // Takes over what `second`, of a file that was read beside, has reserved. Errors: as of a step.
  Result<Done> take_over(MemoryReservation& second);
  void keep_meshes();  // gives back what was waited for and is not needed for them. Call after the last step.

  bool restart() const { return restart_; }             // a step did not fit: free everything, and begin() again
  bool first_attempt() const { return planned_ == 0; }  // no step has failed yet
  std::uint64_t taken_meshes() const { return meshes_.number; }  // since begin()

 private:
  struct Meshes {
    std::uint64_t number = 0, triangles = 0;
    std::uint64_t arrays = 0;  // bytes
  };

  Result<Done> need(std::uint64_t reader, std::uint64_t arrays);
  Error begin_again(std::uint64_t planned);
  Error never(std::uint64_t bytes);

  MemoryBudget& budget_;
  const bool of_second_ = false;
  std::uint64_t reserved_ = 0;
  std::uint64_t planned_ = 0;          // what begin() waits for
  std::uint64_t reader_ = 0;           // beside the arrays
  Meshes meshes_;                      // that were taken
  Meshes read_;                        // of these: that have no reader any more
  std::vector<std::uint64_t> copied_;  // of each mesh that was counted in any attempt: bytes that its reader hands over
  bool restart_ = false;
};

// Calls `attempt(MemoryReservation&)`, again whenever a step did not fit, and returns its last Result. Errors also as
// of MemoryReservation::begin().
template <class Attempt>
auto within(MemoryBudget& budget, Control& control, Attempt attempt) {
  MemoryReservation memory(budget);
  for (;;) {
    using Outcome = decltype(attempt(memory));
    if (auto ok = memory.begin(control); !ok) return Outcome(std::move(ok).error());
    Outcome outcome = attempt(memory);
    if (!memory.restart()) return outcome;
  }
}

// Upper estimate of what a mesh takes with all that measuring makes of it.
std::uint64_t bytes_of_mesh(std::uint64_t vertices, std::uint64_t triangles);

}  // namespace meshgauge::server
