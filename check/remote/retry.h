// Which failures are tried again, how often and after how long.
#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "net/http_client.h"

namespace meshgauge::check::service {

struct RetriedStatus {
  int status;
  int tries;  // in all; 0: as long as patience lasts
};

// Everything that may pass by itself. Every request here may be sent twice: meshes are named by their bytes,
// comparisons by an Idempotency-Key.
std::span<const RetriedStatus> retried_statuses();

// Of one call. The pause doubles from try to try and is drawn at random from its upper half, so that clients that were
// refused together do not come back together; a service that says how long to wait is not asked before.
class Retries {
 public:
  using Clock = std::chrono::steady_clock;
  using Milliseconds = std::chrono::milliseconds;

  static constexpr Milliseconds kFirst{200};
  static constexpr Milliseconds kMost{15'000};

  // Both from the first failure on.
  Retries(Milliseconds patience, Milliseconds first_contact) : patience_(patience), first_contact_(first_contact) {}

  // The pause before the next try; nullopt: it was the last one. `reached`: the service has answered something before.
  // `random`: from 0 to 1.
  std::optional<Milliseconds> after(const net::HttpAnswer& failed, bool reached, Clock::time_point now, double random);

 private:
  const Milliseconds patience_;
  const Milliseconds first_contact_;
  std::optional<Clock::time_point> since_;
  int tries_ = 0;
};

}  // namespace meshgauge::check::service
