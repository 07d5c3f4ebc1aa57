// Decides which failures are retried, how often and after which pause.
#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "net/http_client.h"

namespace meshgauge::check::service {

struct RetriedStatus {
  int status;
  int tries;  // maximum number of tries; 0: until `retry_time` is over
};

// Statuses of transient failures. Every request may be repeated: meshes are named by their bytes, comparisons by an
// Idempotency-Key.
std::span<const RetriedStatus> retried_statuses();

// The retries of one call. The pause doubles from try to try and is drawn from its upper half, so that clients that
// were refused together do not return together. It is never shorter than the service's Retry-After.
class Retries {
 public:
  using Clock = std::chrono::steady_clock;
  using Milliseconds = std::chrono::milliseconds;

  static constexpr Milliseconds kFirst{200};
  static constexpr Milliseconds kMost{15'000};

  // Both times count from the first failure.
  Retries(Milliseconds retry_time, Milliseconds first_contact)
      : retry_time_(retry_time), first_contact_(first_contact) {}

  // Returns the pause before the next try, or nullopt after the last one. `reached`: the service has answered before.
  // `random`: from 0 to 1.
  std::optional<Milliseconds> after(const net::HttpAnswer& failed, bool reached, Clock::time_point now, double random);

 private:
  const Milliseconds retry_time_;
  const Milliseconds first_contact_;
  std::optional<Clock::time_point> since_;
  int tries_ = 0;
};

}  // namespace meshgauge::check::service
