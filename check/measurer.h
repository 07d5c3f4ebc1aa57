// Who measures a gate: this process (local.h) or a service (remote.h). Reports cannot tell the difference.
#pragma once

#include "check/gate.h"
#include "check/outcome.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

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
};

}  // namespace meshgauge::check
