#include "server/store/outage.h"

namespace meshgauge::server::store {

void Outage::failed(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (!out_.exchange(true) && report_) report_(why);
}

// Called after every success, so the common case takes no lock.
void Outage::over() {
  if (!out_) return;
  const std::lock_guard lock(mutex_);
  if (out_.exchange(false) && report_) report_(what_ + " is back");
}

}  // namespace meshgauge::server::store
