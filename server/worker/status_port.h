// The port of a worker: /healthz, /readyz and /metrics alone, with the service's limits and access rules.
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "server/access/access.h"
#include "server/access/entrance.h"
#include "server/handlers/readiness.h"
#include "server/http/http_guard.h"
#include "server/http/router.h"
#include "server/http/tls.h"
#include "server/observe/metrics.h"
#include "server/settings.h"

namespace meshgauge::server {

class StatusPort {
 public:
  // Borrows the last two.
  StatusPort(const Settings& settings, Metrics& metrics, Readiness& readiness);
  ~StatusPort();
  StatusPort(const StatusPort&) = delete;
  StatusPort& operator=(const StatusPort&) = delete;

  // Listens and answers on threads of its own; returns the port.
  Result<int> start();

  bool listening() const { return !ended_.load(); }
  void refuse() { refusing_.store(true); }  // /readyz fails from now on

 private:
  const Settings settings_;
  Metrics& metrics_;
  Readiness& readiness_;
  Access access_;
  const Entrance entrance_;
  std::optional<Tls> tls_;
  Router router_;
  HttpGuard guard_;
  std::atomic<bool> refusing_{false};
  std::atomic<bool> ended_{true};
  std::thread listener_;
};

}  // namespace meshgauge::server
