#include "cli/interrupts.h"

#include <atomic>

namespace meshgauge::cli {
namespace {

// A signal handler must not lock.
std::atomic<bool> interrupted{false};
std::atomic<Control*> cancelled_job{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<Control*>::is_always_lock_free);

void interrupt(int) {
  interrupted = true;
  if (Control* job = cancelled_job) job->cancel();
}

}  // namespace

Interrupts::Interrupts(Control* job) {
  interrupted = false;
  cancelled_job = job;
  struct sigaction action {};
  action.sa_handler = interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, &before_int_);
  sigaction(SIGTERM, &action, &before_term_);
  sigaction(SIGHUP, &action, &before_hang_up_);
  if (before_hang_up_.sa_handler == SIG_IGN) sigaction(SIGHUP, &before_hang_up_, nullptr);  // as nohup has it
}

Interrupts::~Interrupts() {
  sigaction(SIGINT, &before_int_, nullptr);
  sigaction(SIGTERM, &before_term_, nullptr);
  sigaction(SIGHUP, &before_hang_up_, nullptr);
  cancelled_job = nullptr;
}

bool Interrupts::seen() const { return interrupted; }

}  // namespace meshgauge::cli
