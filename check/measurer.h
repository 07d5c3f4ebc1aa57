// Who measures a gate: this process (local.h) or a service (remote.h). Reports cannot tell the difference.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "check/gate.h"
#include "check/outcome.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

// One of several gates that are measured together. Their controls are cancelled together.
struct Task {
  const Gate* gate = nullptr;
  Control* control = nullptr;
  // To be called once, from any thread. `run_ms`: the time of its run alone, where that is known; how long it was
  // waited for says nothing of it.
  std::function<void(Result<Measured>, std::optional<double> run_ms)> ended;
};

class Measurer {
 public:
  virtual ~Measurer() = default;

  // Measures one gate. `control` carries cancellation (Ctrl-C) and the watcher that a progress bar is drawn from; the
  // deadline is the gate's timeout, set by the measurer. Running out of time or patience is a Measured with a valid
  // interval; an Error is about a file, the request or the service. May be called from many threads at once, each with
  // a control of its own.
  virtual Result<Measured> measure(const Gate& gate, Control& control) = 0;

  // How many gates it is worth to measure at the same time.
  virtual unsigned at_once() const = 0;

  // How many gates measure_together() takes at most; 1: each is measured by itself.
  virtual std::size_t together() const { return 1; }

  // As measure() for each of them, told as they end, and all of them when this returns. From many threads at once, as
  // well.
  virtual void measure_together(std::span<const Task> tasks) {
    for (const Task& task : tasks) task.ended(measure(*task.gate, *task.control), std::nullopt);
  }
};

}  // namespace meshgauge::check
