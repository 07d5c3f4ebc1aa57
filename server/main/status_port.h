// A port for /healthz, /readyz and /metrics alone, with a loop and threads of its own: that of a worker, and the second
// one of a service.
#pragma once

#include <atomic>

#include "server/access/entrance.h"
#include "server/base/threads.h"
#include "server/http/http_guard.h"
#include "server/http/router.h"
#include "server/http/tls.h"
#include "server/main/routed_requests.h"
#include "server/observe/metrics.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class StatusPort {
 public:
  // Listens at settings.port. `ready`: answers /readyz. Borrows all but the settings and `ready`.
  StatusPort(const Settings& settings, Metrics& metrics, const Entrance& entrance, const Tls* tls,
             Router::Action ready);
  ~StatusPort() = default;
  StatusPort(const StatusPort&) = delete;
  StatusPort& operator=(const StatusPort&) = delete;

  // Listens and answers on threads of its own; returns the port.
  Result<int> start();

  bool listening() const { return !ended_.load(); }
  const HttpGuard& guard() const { return guard_; }

 private:
  void tell_end();

  const Settings settings_;
  Router router_;
  RoutedRequests requests_;
  HttpGuard guard_;
  std::atomic<bool> ended_{true};
  Threads listener_;
};

}  // namespace meshgauge::server
