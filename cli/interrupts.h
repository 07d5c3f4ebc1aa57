// Ctrl-C and SIGTERM as something to ask for, or to cancel a job.
#pragma once

#include <signal.h>

#include "engine/control.h"

namespace meshgauge::cli {

// While one lives, the first signal is noted, and a second one of the same kind ends the process. One at a time.
class Interrupts {
 public:
  explicit Interrupts(Control* job = nullptr);  // that is cancelled; null: nothing is
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  bool seen() const;

 private:
  struct sigaction before_int_ {};
  struct sigaction before_term_ {};
};

}  // namespace meshgauge::cli
