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
  double ms = 0;  // since the gate began
};

struct Standing {
  std::size_t gates = 0;
  std::size_t done = 0;
  std::vector<Running> running;   // longest running first
  const char* counted = "gates";  // what `gates` and `done` are numbers of
};

// Callbacks of a run, called on the caller's thread, except `after`.
struct Watch {
  std::function<bool()> interrupted;                               // asked every 10 ms; true ends the run; may be empty
  std::function<void(const Standing&)> standing;                   // called ten times a second; may be empty
  std::function<void(const GateOutcome&, const Standing&)> ended;  // called once for each gate that ends; may be empty
  // Called for each gate that has begun, on any thread that measures, before it counts as ended: makes pictures and
  // maps while its meshes are in memory. `control` is cancelled when the run is interrupted. May be empty.
  std::function<void(std::size_t place, const GateOutcome&, Control& control)> after;
};

// Returns the outcomes in the order of `gates`. Gates with large files begin first, so that the end does not wait for
// one of them; gates with the same large file run one after another, so that it is held briefly. When interrupted,
// running gates return their intervals so far and the others do not begin. Exceptions of `after` are ignored.
Report run(const std::vector<Gate>& gates, Measurer& measurer, const Watch& watch = {});

// Returns the order in which gates begin, as indices into `gates`.
std::vector<std::size_t> order_of(const std::vector<Gate>& gates);

}  // namespace meshgauge::check
