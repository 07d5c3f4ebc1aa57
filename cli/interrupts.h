// Turns Ctrl-C, SIGTERM and SIGHUP into a flag, and cancels a job.
#pragma once

#include <signal.h>

#include "engine/control.h"

namespace meshgauge::cli {

// While it lives, the first signal is recorded; a second one of the same kind ends the process. At most one object at
// a time.
class Interrupts {
 public:
  explicit Interrupts(Control* job = nullptr);  // job to cancel; null: none
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  bool seen() const;

 private:
  struct sigaction before_int_ {};
  struct sigaction before_term_ {};
  struct sigaction before_hang_up_ {};
};

}  // namespace meshgauge::cli
