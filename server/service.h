// The whole service: routes, guard and workers wired together.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/result.h"
#include "server/comparisons.h"
#include "server/http_guard.h"
#include "server/router.h"
#include "server/settings.h"

namespace meshgauge::server {

class Service {
 public:
  // Precondition: settings come from checked().
  Service(const Settings& settings, Compare compare);
  ~Service();  // as shutdown() without grace
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // Listens and serves on threads of its own; returns the port. An Error says why it cannot.
  Result<int> start();

  bool listening() const { return !ended_.load() && !guard_.draining(); }

  // Takes no new work, lets running requests finish until `hurry` says so (asked every 50 ms), then cancels them:
  // each still gets its answer, with the interval it has reached.
  void shutdown(const std::function<bool()>& hurry);

 private:
  void add_routes();

  const Settings settings_;
  Comparisons comparisons_;
  Router router_;
  HttpGuard guard_;
  std::thread listener_;
  std::atomic<bool> ended_{true};
};

// Serves until SIGTERM or SIGINT; a second one ends the grace. An Error when it could not start or go on listening.
// Blocks both signals in the calling thread and those it starts. Uploads are read by processes that `parser` makes: a
// program and its arguments that calls sandbox::run_spawner().
Result<Done> run_until_signal(const Settings& settings, const std::vector<std::string>& parser);

}  // namespace meshgauge::server
