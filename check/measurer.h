// Measures gates, in this process (run/local.h) or by a service (remote.h). Reports do not depend on which.
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

// One of several gates that are measured together. Cancelling one control cancels all of them.
struct Task {
  const Gate* gate = nullptr;
  Control* control = nullptr;
  // Called once, from any thread. `run_ms`: running time without waiting; nullopt: not known.
  std::function<void(Result<Measured>, std::optional<double> run_ms)> ended;
};

class Measurer {
 public:
  virtual ~Measurer() = default;

  // Measures one gate. `control` carries cancellation (Ctrl-C) and the watcher of the progress bar; the measurer sets
  // its deadline to the gate's timeout. Running out of time or budget gives a Measured with a valid interval. An
  // Error is about a file, the request or the service. Thread safe, with a control for each call.
  virtual Result<Measured> measure(const Gate& gate, Control& control) = 0;

  // Number of gates worth measuring at the same time.
  virtual unsigned at_once() const = 0;

  // Maximum number of gates for measure_together(); 1: each gate is measured by itself.
  virtual std::size_t together() const { return 1; }

  // Calls measure() for each task and task.ended with its result; returns when all have ended. Thread safe.
  virtual void measure_together(std::span<const Task> tasks) {
    for (const Task& task : tasks) task.ended(measure(*task.gate, *task.control), std::nullopt);
  }
};

}  // namespace meshgauge::check
