#include "check/run/local.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <span>
#include <utility>

#include "api/compare/compare.h"
#include "api/options/request.h"
#include "api/result/response.h"

namespace meshgauge::check {
namespace {

Error named(Error error, const char* part) {
  error.part = part;
  return error;
}

class Local final : public Measurer {
 public:
  Local(std::size_t gates, std::shared_ptr<Meshes> meshes, const LocalOptions& options)
      : meshes_(std::move(meshes)),
        at_once_(static_cast<unsigned>(
            std::clamp<std::size_t>(gates, 1, std::max(1U, options.jobs ? options.jobs : options.processors)))),
        most_threads_(std::max(1U, options.processors)),
        processors_(most_threads_, at_once_, gates) {}

  unsigned at_once() const override { return at_once_; }

  void measure(std::span<const Task> tasks) override {
    for (const Task& task : tasks) task.ended(measured(*task.gate, *task.control), std::nullopt);
  }

 private:
  // A running gate's threads and meshes.
  struct Seat {
    Seat(Local& its_owner, const Gate& its_gate, Control& its_control)
        : owner(its_owner), gate(its_gate), control(its_control), threads(owner.processors_.take(owner.wanted(gate))) {}
    // After Ctrl-C the meshes stay in memory: freeing a million triangles would delay the end.
    ~Seat() {
      owner.processors_.give_back(threads);
      if (control.check() != Interruption::cancelled) owner.meshes_->done(gate);
    }
    Seat(const Seat&) = delete;
    Seat& operator=(const Seat&) = delete;

    Local& owner;
    const Gate& gate;
    Control& control;
    const unsigned threads;
  };

  // Only `automatic` uses more than one thread. A manifest that is not trusted gets no more than there are.
  unsigned wanted(const Gate& gate) const {
    if (gate.request.options.strategy != Strategy::automatic) return 1;
    const unsigned asked = gate.request.threads_given ? gate.request.options.threads : 0;
    return gate.confines ? std::min(asked, most_threads_) : asked;
  }

  Result<Measured> measured(const Gate& gate, Control& control) {
    control.set_deadline(Control::Clock::now() + gate.request.timeout);
    const Seat seat(*this, gate, control);
    return measured(gate, seat.threads, control);
  }

  Result<Measured> measured(const Gate& gate, unsigned threads, Control& control) {
    const auto start = Control::Clock::now();
    if (api::reads_side_by_side(threads)) meshes_->begin(gate.baseline);
    const auto candidate = meshes_->get(gate.candidate, control);
    if (!candidate) return named(candidate.error(), "a");
    // Before it is aligned; without a_to_b it is refused anyway.
    if (auto undeclared = undeclared_cloud(gate, (*candidate)->facts);
        undeclared && gate.request.options.direction == Direction::a_to_b)
      return *undeclared;
    api::StageTimes times;
    times.read_a = ms_since(start);
    const auto baseline = meshes_->get(gate.baseline, control);
    if (!baseline) return named(baseline.error(), "b");
    times.read_b = ms_since(start) - times.read_a;

    api::ComparisonOptions options = gate.request.options;
    options.threads = std::min(threads, static_cast<unsigned>(api::kThreadsRange.high));
    const auto comparison = api::compare(*candidate, *baseline, options, control, times);
    if (!comparison) return with_files(comparison.error(), gate);
    return measured_from(api::document_of(*comparison), gate);
  }

  const std::shared_ptr<Meshes> meshes_;
  const unsigned at_once_;
  const unsigned most_threads_;
  Processors processors_;
};

}  // namespace

std::unique_ptr<Measurer> local(const std::vector<Gate>& gates, std::shared_ptr<Meshes> meshes,
                                const LocalOptions& options) {
  return std::make_unique<Local>(gates.size(), std::move(meshes), options);
}

}  // namespace meshgauge::check
