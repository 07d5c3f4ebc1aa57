#include "check/run/run.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

namespace meshgauge::check {
namespace {

using Clock = Control::Clock;

constexpr std::chrono::milliseconds kTick{10};  // how soon Ctrl-C is seen
constexpr std::chrono::milliseconds kShowEvery{100};

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(file, failed);
  return failed ? 0 : bytes;  // measuring it will say what is wrong
}

// Exceptions end here.
Result<Measured> measure(Measurer& measurer, const Gate& gate, Control& control) try {
  return measurer.measure(gate, control);
} catch (const std::exception& error) {
  return Error{ErrorCode::internal, std::string("the measurement failed unexpectedly: ") + error.what(), "", ""};
}

GateOutcome outcome_of(const Gate& gate, Result<Measured> result, Control& stopped) {
  GateOutcome outcome;
  outcome.gate = gate;
  if (result) {
    outcome.measured = std::move(*result);
    return outcome;
  }
  outcome.interrupted = result.error().code == ErrorCode::out_of_time;
  const bool by_caller = stopped.check() == Interruption::cancelled;
  if (!outcome.interrupted || !by_caller) outcome.error = std::move(result).error();
  return outcome;
}

bool cut(const GateOutcome& outcome) {
  return outcome.interrupted || (outcome.measured && outcome.measured->status == "cancelled");
}

class Run {
 public:
  Run(const std::vector<Gate>& gates, Measurer& measurer, const Watch& watch)
      : gates_(gates), measurer_(measurer), watch_(watch), order_(order_of(gates)), outcomes_(gates.size()) {}

  Report all() {
    const auto threads = std::clamp<std::size_t>(measurer_.at_once(), 1, std::max<std::size_t>(gates_.size(), 1));
    std::vector<std::thread> workers;
    try {
      while (workers.size() < threads) workers.emplace_back([this] { work(); });
    } catch (const std::system_error&) {  // fewer gates at the same time, then
      if (workers.empty()) throw;
    }
    const Joined joined{*this, workers};
    oversee();
    joined.wait();
    return report();
  }

 private:
  // Whatever the watch throws, no worker is left: then what runs is cancelled, and the rest does not begin.
  struct Joined {
    ~Joined() {
      {
        const std::lock_guard lock(run.mutex_);
        run.stop();
      }
      wait();
    }
    void wait() const {
      for (std::thread& worker : workers) {
        if (worker.joinable()) worker.join();
      }
    }
    Run& run;
    std::vector<std::thread>& workers;
  };

  struct Job {
    std::size_t gate;
    Clock::time_point start = Clock::now();
    Control control;  // of the measurement
    Control after;    // of what comes after it: the gate's deadline is not its
    Progress progress;

    explicit Job(std::size_t its_gate) : gate(its_gate) {}
  };

  void work() {
    while (Job* job = next()) {
      job->control.watch([this, job](const Progress& progress) { note(*job, progress); }, kShowEvery);
      const Gate& gate = gates_[job->gate];
      GateOutcome outcome = outcome_of(gate, measure(measurer_, gate, job->control), job->after);
      outcome.wall_ms = ms_since(job->start);
      if (watch_.after) keep(outcome, *job);
      finish(*job, std::move(outcome));
    }
  }

  // A picture that cannot be made is no reason to lose what was measured.
  void keep(const GateOutcome& outcome, Job& job) try {
    watch_.after(job.gate, outcome, job.after);
  } catch (const std::exception&) {
  }

  // Null: nothing is left to begin.
  Job* next() {
    const std::lock_guard lock(mutex_);
    if (stopped_ || begun_ == order_.size()) return nullptr;
    jobs_.emplace_back(order_[begun_++]);
    running_.push_back(&jobs_.back());
    return running_.back();
  }

  void note(Job& job, const Progress& progress) {
    const std::lock_guard lock(mutex_);
    job.progress = progress;
  }

  void finish(const Job& job, GateOutcome outcome) {
    const std::lock_guard lock(mutex_);
    outcomes_[job.gate] = std::move(outcome);
    running_.erase(std::find(running_.begin(), running_.end(), &job));
    ended_.push_back(job.gate);
    changed_.notify_all();
  }

  void oversee() {
    std::unique_lock lock(mutex_);
    auto shown = Clock::now() - kShowEvery;
    std::size_t told = 0;
    while (!over() || told < ended_.size()) {
      if (told == ended_.size()) changed_.wait_for(lock, kTick);
      if (!stopped_ && watch_.interrupted && watch_.interrupted()) stop();
      for (; told < ended_.size(); ++told) {
        const GateOutcome& outcome = *outcomes_[ended_[told]];  // nobody writes it any more
        if (watch_.ended) unlocked(lock, [&, now = standing()] { watch_.ended(outcome, now); });
      }
      if (watch_.standing && Clock::now() >= shown + kShowEvery) {
        unlocked(lock, [&, now = standing()] { watch_.standing(now); });
        shown = Clock::now();
      }
    }
  }

  bool over() const { return running_.empty() && (stopped_ || begun_ == order_.size()); }

  void stop() {
    stopped_ = true;
    for (Job* job : running_) job->control.cancel(), job->after.cancel();
  }

  Standing standing() const {
    Standing now{gates_.size(), ended_.size(), {}};
    for (const Job* job : running_) now.running.push_back({&gates_[job->gate], job->progress, ms_since(job->start)});
    return now;
  }

  template <class Work>
  static void unlocked(std::unique_lock<std::mutex>& lock, const Work& work) {
    lock.unlock();
    work();
    lock.lock();
  }

  Report report() {
    Report report;
    report.version = version();
    for (std::size_t i = 0; i < gates_.size(); ++i) {
      if (!outcomes_[i]) {
        outcomes_[i].emplace().gate = gates_[i];
        outcomes_[i]->interrupted = true;
      }
      report.interrupted = report.interrupted || (stopped_ && cut(*outcomes_[i]));
      report.outcomes.push_back(std::move(*outcomes_[i]));
    }
    return report;
  }

  const std::vector<Gate>& gates_;
  Measurer& measurer_;
  const Watch& watch_;
  const std::vector<std::size_t> order_;

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::size_t begun_ = 0;
  bool stopped_ = false;
  std::deque<Job> jobs_;            // begun; their places do not change
  std::vector<Job*> running_;       // as they began
  std::vector<std::size_t> ended_;  // gates, as they ended
  std::vector<std::optional<GateOutcome>> outcomes_;
};

}  // namespace

std::vector<std::size_t> order_of(const std::vector<Gate>& gates) {
  struct Rank {
    std::uintmax_t largest = 0;
    std::filesystem::path name;  // of the larger file: gates that share it stay together
    std::uintmax_t other = 0;
  };
  std::vector<std::pair<Rank, std::size_t>> ranks;
  for (std::size_t i = 0; i < gates.size(); ++i) {
    const auto candidate = size_of(gates[i].candidate), baseline = size_of(gates[i].baseline);
    const auto& larger = candidate > baseline ? gates[i].candidate : gates[i].baseline;
    ranks.push_back({{std::max(candidate, baseline), larger, std::min(candidate, baseline)}, i});
  }
  std::stable_sort(ranks.begin(), ranks.end(), [](const auto& x, const auto& y) {
    return std::tie(y.first.largest, x.first.name, y.first.other) <
           std::tie(x.first.largest, y.first.name, x.first.other);
  });
  std::vector<std::size_t> order;
  order.reserve(ranks.size());
  for (const auto& [rank, place] : ranks) order.push_back(place);
  return order;
}

Report run(const std::vector<Gate>& gates, Measurer& measurer, const Watch& watch) {
  return Run(gates, measurer, watch).all();
}

}  // namespace meshgauge::check
