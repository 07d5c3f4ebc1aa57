// The compute workers: a fixed pool behind bounded queues, apart from the threads that serve connections.
//
// A slot is taken before a request's body is read and held until its job has run, so that every accepted request is
// served. There are two kinds of slots, each with its limit: for clients that wait, and for durable jobs. A client
// alone may take all slots of a kind. Others then still find slots within their shares, a quarter above the limit at
// most (share.h).
//
// Beside the workers there are kGuests threads for clients that have no job running: the jobs of one client, however
// many and hard, do not keep another's first one waiting. The processors are then shared by the operating system.
//
// A client is the owner of a key; without keys, an address (its tag).
//
// Order. The client with the fewest running jobs is next; of its jobs the one with the earliest turn. A turn is the
// time of the submission plus the expected cost of the job's bytes, at most kMostHandicap and a quarter of its timeout.
// So a small job overtakes large ones that came shortly before it, and no job is overtaken by one that comes more than
// kMostHandicap later. What a client has beyond its share is the last of its jobs and waits while others come.
#pragma once

#include <condition_variable>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/control.h"
#include "server/base/share.h"
#include "server/base/threads.h"

namespace meshgauge::server {

class Scheduler {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kMostHandicap{30'000};
  static constexpr std::uint64_t kBytesPerMs = 10'000;  // read and measured; a low estimate

  enum class Kind { awaited, durable };

  struct Limits {
    std::size_t workers = 1;
    std::size_t awaited = 1;  // slots, for jobs that run or wait
    std::size_t durable = 1;
  };

  class Slot {
   public:
    Slot(Slot&& other) noexcept
        : scheduler_(std::exchange(other.scheduler_, nullptr)), kind_(other.kind_), client_(std::move(other.client_)) {}
    Slot& operator=(Slot&&) = delete;
    ~Slot();

    Kind kind() const { return kind_; }

   private:
    friend class Scheduler;
    Slot(Scheduler* scheduler, Kind kind, std::string client)
        : scheduler_(scheduler), kind_(kind), client_(std::move(client)) {}
    Scheduler* scheduler_;
    Kind kind_;
    std::string client_;
  };

  struct Task {
    std::string client;
    std::uint64_t bytes = 0;  // to be read
    std::chrono::milliseconds timeout = std::chrono::milliseconds::max();
    std::shared_ptr<Control> control;
    // Must not throw. Gives the slot back before it publishes its result: the client may send the next request at once.
    std::function<void(Slot)> work;
  };

  struct Figures {
    std::size_t waiting = 0;
    std::size_t running = 0;
    std::size_t awaited_slots = 0;  // taken
    std::size_t durable_slots = 0;
  };

  explicit Scheduler(const Limits& limits);
  ~Scheduler() = default;  // as end()
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  std::optional<Slot> admit(Kind kind, const std::string& client);  // nullopt: next_place() is none
  bool has_place(Kind kind, const std::string& client) const;       // whether admit() would succeed now
  bool has_place_for_new_client(Kind kind) const;                   // one that has no place yet
  Slot admit_again(const std::string& client);               // for a durable job from before a restart: always succeeds
  Slot uncounted() { return {nullptr, Kind::durable, ""}; }  // for a job that is counted elsewhere
  void submit(Slot slot, Task task);                         // never blocks
  bool withdraw(const Control& control);                     // removes a waiting task; false: it does not wait
  void cancel_all();                                         // running, waiting and future tasks
  // Runs what was submitted, then ends the workers. Precondition: no submit() afterwards.
  void end() { workers_.end(); }

  Figures figures() const;
  // Estimates how long a new job would wait: the time of a job by the number of jobs before it, per worker. The time of
  // a job is the mean of the last ones, or what the running ones have taken so far if that is more. `elsewhere`:
  // further jobs before it.
  std::chrono::milliseconds expected_wait(std::size_t elsewhere = 0) const;

 private:
  struct Entry {
    Slot slot;
    Task task;
    Clock::time_point turn;
  };

  struct Slots {
    std::size_t limit = 0;
    TakenPlaces taken{};
    std::map<std::string, TakenPlaces> of{};  // by client; none without places

    NextPlace next(const std::string& client) const;
    void take(const std::string& client, NextPlace place);
    void give(const std::string& client);
  };

  struct Running {
    Control* control;
    Clock::time_point since;
  };

  using Waiting = std::list<Entry>;

  void work();
  void tell_end();
  Waiting::iterator next();
  Entry take(Waiting::iterator next);
  std::size_t running_of(const std::string& client) const;
  double time_of_job_ms() const;
  void ran_for(double ms);
  void release(Kind kind, const std::string& client);
  Slots& slots(Kind kind) { return kind == Kind::awaited ? awaited_ : durable_; }

  const Limits limits_;
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  Slots awaited_;
  Slots durable_;
  Waiting waiting_;
  std::map<std::string, std::size_t> running_of_;  // by client; no zeros
  std::vector<Running> running_;
  double mean_ms_ = 0;  // of the first jobs' times; then their exponential mean
  std::uint64_t ended_ = 0;
  bool cancelled_ = false;
  bool ending_ = false;
  Threads workers_;
};

}  // namespace meshgauge::server
