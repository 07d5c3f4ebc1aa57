#include "server/measure/stores.h"

#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::seconds kBetweenErrorLines{10};

StoreFailure failure_of(ErrorCode code) {
  if (code == ErrorCode::storage_full) return StoreFailure::full;
  return code == ErrorCode::storage_unavailable ? StoreFailure::unavailable : StoreFailure::broken;
}

}  // namespace

std::string located(const std::string& defect, const std::string& place) {
  return place.empty() ? defect : defect + " (" + place + ")";
}

void StoreErrors::failed(const Error& error) {
  metrics_.store_failed(failure_of(error.code));
  {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    if (error.message == last_ && now - logged_ < kBetweenErrorLines) return;
    last_ = error.message;
    logged_ = now;
  }
  log_event("store", located(error.message, place_));
}

}  // namespace meshgauge::server
