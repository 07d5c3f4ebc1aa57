// The whole service: routes, guard and workers wired together.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.h"
#include "server/access/access.h"
#include "server/access/entrance.h"
#include "server/base/threads.h"
#include "server/handlers/batches.h"
#include "server/handlers/comparisons.h"
#include "server/handlers/deviations.h"
#include "server/handlers/listings.h"
#include "server/handlers/meshes.h"
#include "server/handlers/readiness.h"
#include "server/http/http_guard.h"
#include "server/http/router.h"
#include "server/http/tls.h"
#include "server/jobs/jobs.h"
#include "server/main/routed_requests.h"
#include "server/main/status_port.h"
#include "server/observe/metrics.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class Service {
 public:
  // Precondition: settings come from checked(). Borrows the loader and the stores. Without stores.maps there are
  // no routes for deviation maps, without stores.batches none for batches.
  Service(const Settings& settings, MeshLoader& loader, const Stores& stores);
  ~Service();  // as shutdown() without a grace period
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // Listens, serves on threads of its own, and returns the port. An Error says why it cannot.
  Result<int> start();

  void reload();  // see reload_secrets()

  Metrics& metrics() { return metrics_; }        // to add levels before start()
  Readiness& readiness() { return readiness_; }  // to add checks before start()

  bool listening() const { return !ended_.load() && !guard_.draining(); }

  // Accepts no new work and waits for running requests until `give_up` returns true (called every 50 ms). Then cancels
  // them; each is still answered, with the interval reached so far. Blocks until all threads have ended.
  void shutdown(const std::function<bool()>& give_up);

 private:
  void add_routes();
  void add_page_routes();
  void add_comparison_routes();
  void add_batch_routes();
  void add_listing_routes();

  void watch_levels();
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
  std::optional<Listings> listings_;
  Router router_;
  RoutedRequests requests_;
  HttpGuard guard_;
  Readiness readiness_;
  std::optional<StatusPort> status_;
  std::atomic<bool> ended_{true};
  Threads listener_;
};

// Runs the service until SIGTERM, SIGINT or the end of its terminal; a second such signal ends the grace period. Any
// other SIGHUP calls Service::reload(). Returns an Error if the service could not start, or could not go on listening.
// Blocks these signals in the calling thread and the threads it starts. `parser`: the command line of the spawner of
// reader processes, a program that calls sandbox::run_spawner().
Result<Done> run_until_signal(const Settings& settings, const std::vector<std::string>& parser);

}  // namespace meshgauge::server
