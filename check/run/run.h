// Measures all gates of a run, as many at the same time as their measurer takes.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "check/gate.h"
#include "check/measurer.h"
#include "check/outcome.h"
#include "engine/control.h"

namespace meshgauge::check {

struct Running {
  const Gate* gate = nullptr;
  Progress progress;
  double ms = 0;  // since it began
};

struct Standing {
  std::size_t gates = 0;
  std::size_t done = 0;
  std::vector<Running> running;  // the longest first
};

// What the caller is told and asked meanwhile, on its own thread but for `after`.
struct Watch {
  std::function<bool()> interrupted;              // asked every 10 ms: whether to end now; may be empty
  std::function<void(const Standing&)> standing;  // ten times a second; may be empty
  std::function<void(const GateOutcome&, const Standing&)> ended;  // once for a gate, as they end; may be empty
  // With the place of each gate that has begun, on the thread that has measured it, before it counts as ended: what is
  // made of its meshes while they are at hand. `control` is cancelled when the run is interrupted. May be empty.
  std::function<void(std::size_t place, const GateOutcome&, Control& control)> after;
};

// The outcomes are in the order of `gates`. Large files begin first, so that the end does not wait for one of them, and
// gates with the same large file one after another, so that it is held for a short time. Interrupted, running gates
// return the intervals that they have and the rest does not begin. What `after` throws is lost.
Report run(const std::vector<Gate>& gates, Measurer& measurer, const Watch& watch = {});

// The order in which they begin: places in `gates`.
std::vector<std::size_t> order_of(const std::vector<Gate>& gates);

}  // namespace meshgauge::check
