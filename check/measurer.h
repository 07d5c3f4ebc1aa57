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

// A gate to measure. `control` carries cancellation (Ctrl-C) and the watcher of the progress bar; a measurer in this
// process sets its deadline to the gate's timeout. Of several gates that are measured together, cancelling one control
// cancels all.
struct Task {
  const Gate* gate = nullptr;
  Control* control = nullptr;
  // Called once, from any thread. Running out of time or budget gives a Measured with a valid interval; an Error is
  // about a file, the request or the service. `run_ms`: running time without waiting; nullopt: not known.
  std::function<void(Result<Measured>, std::optional<double> run_ms)> ended;
};

class Measurer {
 public:
  virtual ~Measurer() = default;

  // Number of calls of measure() that are worth making at the same time.
  virtual unsigned at_once() const = 0;

  // Maximum number of tasks of one call.
  virtual std::size_t together() const { return 1; }

  // Measures the tasks; returns when all have ended. Thread safe, with controls for each call.
  virtual void measure(std::span<const Task> tasks) = 0;
};

}  // namespace meshgauge::check
