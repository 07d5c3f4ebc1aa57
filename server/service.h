// The whole service: routes, guard and workers wired together.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/result.h"
#include "server/access/access.h"
#include "server/access/entrance.h"
#include "server/handlers/batches.h"
#include "server/handlers/comparisons.h"
#include "server/handlers/deviations.h"
#include "server/handlers/meshes.h"
#include "server/handlers/readiness.h"
#include "server/http/http_guard.h"
#include "server/http/router.h"
#include "server/http/tls.h"
#include "server/jobs/jobs.h"
#include "server/observe/metrics.h"
#include "server/settings.h"

namespace meshgauge::server {

class Service {
 public:
  // Precondition: settings come from checked().
  // Borrows the stores. Deviation maps are made if there is a `fetch` and a cache for them in `stores`, batches taken
  // if there is a place for them.
  Service(const Settings& settings, const Fetch& fetch, Stores stores);
  ~Service();  // as shutdown() without grace
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // Listens and serves on threads of its own; returns the port. An Error says why it cannot.
  Result<int> start();

  // Reads keys, certificate and its key anew, and logs what became of it; what cannot be used leaves the old ones.
  void reload();

  // Where others than the service have something to be watched, before start().
  Metrics& metrics() { return metrics_; }

  // What else must be in order for a request to be taken, before start().
  Readiness& readiness() { return readiness_; }

  bool listening() const { return !ended_.load() && !guard_.draining(); }

  // Takes no new work, lets running requests finish until `give_up` says so (asked every 50 ms), then cancels them:
  // each still gets its answer, with the interval it has reached.
  void shutdown(const std::function<bool()>& give_up);

 private:
  void add_routes();
  void add_comparison_routes();
  void add_batch_routes();
  Result<Done> load_secrets();

  void watch_levels();
  std::uint64_t free_bytes() const;
  std::uint64_t stored_bytes() const;
  void check_ready(Exchange& exchange);

  const Settings settings_;
  const Stores stores_;
  Metrics metrics_;
  Access access_;
  const Entrance entrance_;
  std::optional<Tls> tls_;
  ByteBudget uploads_;
  Jobs jobs_;
  Comparisons comparisons_;
  std::optional<Deviations> deviations_;
  std::optional<Batches> batches_;
  Meshes meshes_;
  Router router_;
  HttpGuard guard_;
  Readiness readiness_;
  std::thread listener_;
  std::atomic<bool> ended_{true};
};

// Serves until SIGTERM or SIGINT, or until its terminal is closed; a second one ends the grace. SIGHUP by anyone else
// is for Service::reload(). An Error when it could not start or go on listening. Blocks these signals in the calling
// thread and those it starts. Uploads are read by processes that `parser` makes: a program and its arguments that calls
// sandbox::run_spawner().
Result<Done> run_until_signal(const Settings& settings, const std::vector<std::string>& parser);

}  // namespace meshgauge::server
