#include "check/run/run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

#include "api/base/refused.h"
#include "api/result/examination.h"
#include "engine/hausdorff.h"

namespace meshgauge::check {
namespace {

using Clock = Control::Clock;

constexpr std::chrono::milliseconds kStopTick{10};  // time until Ctrl-C is noticed
constexpr std::chrono::milliseconds kShowEvery{100};

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(file, failed);
  return failed ? 0 : bytes;  // measuring reports the problem
}

Result<Measured> refused_by(const std::vector<Mistake>& defects) {
  std::string why;
  for (const Mistake& defect : defects) why += (why.empty() ? "" : "; ") + defect.message;
  const Mistake& first = defects.front();
  if (first.line == 0) return refused(why);
  return refused(why, "", "line " + std::to_string(first.line) + ", column " + std::to_string(first.column));
}

GateOutcome outcome_of(const Gate& gate, Result<Measured>&& result, Control& stopped) {
  GateOutcome outcome;
  outcome.gate = gate;
  if (auto undeclared = result ? undeclared_cloud(gate, result->document) : std::nullopt) {
    outcome.error = std::move(*undeclared);
    return outcome;
  }
  if (result) {
    outcome.measured = std::move(*result);
    static const nlohmann::ordered_json kNone;
    const auto meshes = outcome.measured->document.find("meshes");
    outcome.expectations = examined(gate.request.options.expect,
                                    meshes == outcome.measured->document.end() ? kNone : *meshes, outcome.unit());
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
    const Joined joined{*this, workers};  // first: whatever is thrown below, the threads are joined
    try {
      while (workers.size() < threads) workers.emplace_back([this] { work(); });
    } catch (const std::system_error&) {  // continue with fewer gates at the same time
      if (workers.empty()) throw;
    }
    oversee();
    joined.wait();
    return report();
  }

 private:
  // If a callback throws: cancels running gates, begins no more, and joins the threads.
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
    Control after;    // of the work after it, which the gate's deadline does not limit
    Progress progress;
    std::atomic<bool> ended{false};  // the result has arrived

    explicit Job(std::size_t its_gate) : gate(its_gate) {}
  };

  // Any free thread makes pictures, since gates of one batch end faster than one thread makes them.
  void work() {
    std::unique_lock lock(mutex_);
    while (!over()) {
      if (!measured_.empty()) {
        auto [job, outcome] = std::move(measured_.front());
        measured_.pop_front();
        if (outcome.measured) job->progress = {outcome.measured->lower, outcome.measured->upper, "drawing"};
        unlocked(lock, [&, job = job, &outcome = outcome] {
          keep(outcome, *job);
          finish(*job, std::move(outcome));
        });
      } else if (const std::vector<Job*> some = next(); !some.empty()) {
        unlocked(lock, [&] { measure(some); });
      } else {
        changed_.wait_for(lock, kStopTick);
      }
    }
  }

  // An exception becomes the Error of each gate without a result.
  void measure(const std::vector<Job*>& jobs) {
    std::vector<Task> tasks;
    tasks.reserve(jobs.size());
    for (Job* job : jobs) {
      const auto& defects = gates_[job->gate].defects;
      if (!defects.empty()) end(*job, refused_by(defects));
      if (defects.empty())
        tasks.push_back({&gates_[job->gate], &job->control,
                         [this, job](Result<Measured>&& result, auto ms) { end(*job, std::move(result), ms); }});
    }
    std::string why = "it was left out";
    try {
      if (!tasks.empty()) measurer_.measure(tasks);
    } catch (const std::exception& error) {
      why = error.what();
    }
    for (Job* job : jobs) {
      if (!job->ended) end(*job, Error{ErrorCode::internal, "the measurement failed unexpectedly: " + why, "", ""});
    }
  }

  void end(Job& job, Result<Measured>&& result, std::optional<double> run_ms = {}) {
    GateOutcome outcome = outcome_of(gates_[job.gate], std::move(result), job.after);
    outcome.wall_ms = std::min(ms_since(job.start), run_ms.value_or(std::numeric_limits<double>::infinity()));
    job.ended = true;
    if (!watch_.after) return finish(job, std::move(outcome));
    const std::lock_guard lock(mutex_);
    measured_.emplace_back(&job, std::move(outcome));
    changed_.notify_all();
  }

  // A picture that cannot be made must not lose the measurement.
  void keep(const GateOutcome& outcome, Job& job) try {
    watch_.after(job.gate, outcome, job.after);
  } catch (const std::exception&) {
  }

  // Empty: no gate is left to begin.
  std::vector<Job*> next() {
    std::vector<Job*> some;
    const std::size_t most = measurer_.together();
    while (!stopped_ && begun_ < order_.size() && some.size() < std::max<std::size_t>(most, 1)) {
      Job& job = jobs_.emplace_back(order_[begun_++]);
      job.control.watch([this, &job](const Progress& progress) { note(job, progress); }, kShowEvery);
      running_.push_back(&job);
      some.push_back(&job);
    }
    return some;
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
      if (told == ended_.size()) changed_.wait_for(lock, kStopTick);
      if (!stopped_ && watch_.interrupted && watch_.interrupted()) stop();
      for (; told < ended_.size(); ++told) {
        const GateOutcome& outcome = *outcomes_[ended_[told]];  // no thread writes it any more
        if (watch_.ended) unlocked(lock, [&, now = standing(told + 1)] { watch_.ended(outcome, now); });
      }
      if (watch_.standing && Clock::now() >= shown + kShowEvery) {
        unlocked(lock, [&, now = standing(ended_.size())] { watch_.standing(now); });
        shown = Clock::now();
      }
    }
  }

  bool over() const { return running_.empty() && (stopped_ || begun_ == order_.size()); }

  void stop() {
    stopped_ = true;
    changed_.notify_all();
    for (Job* job : running_) job->control.cancel(), job->after.cancel();
  }

  Standing standing(std::size_t done) const {
    Standing now{gates_.size(), done, {}};
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

  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::size_t begun_ = 0;
  bool stopped_ = false;
  std::deque<Job> jobs_;                               // gates that have begun; addresses are stable
  std::vector<Job*> running_;                          // in the order in which they began
  std::deque<std::pair<Job*, GateOutcome>> measured_;  // results whose after() has not run yet
  std::vector<std::size_t> ended_;                     // indices of gates, in the order in which they ended
  std::vector<std::optional<GateOutcome>> outcomes_;
};

}  // namespace

std::vector<std::size_t> order_of(const std::vector<Gate>& gates) {
  struct Rank {
    std::uintmax_t largest = 0;
    std::filesystem::path name;  // of the larger file: gates that share it run one after another
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
