#include "server/main/worker.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <limits>

#include "api/base/digest.h"
#include "api/base/refused.h"
#include "server/access/entrance.h"
#include "server/base/each_second.h"
#include "server/base/heap.h"
#include "server/handlers/readiness.h"
#include "server/http/descriptors.h"
#include "server/jobs/upkeep.h"
#include "server/main/status_port.h"
#include "server/main/wiring.h"
#include "server/measure/caching_mesh_loader.h"
#include "server/observe/log.h"
#include "server/worker/worker.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLook{50};
constexpr std::size_t kOpeners = 4;  // these threads wait for the network, not for a processor

// Unique, also among past and future processes; begins with the name of the machine, for operators.
std::string worker_name() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return std::string(host.data()) + "/" + api::random_id();
}

WorkerOptions options_of(const Settings& settings) {
  WorkerOptions options;
  options.name = worker_name();
  options.lease = milliseconds(settings.lease_ms);
  options.heartbeat = milliseconds(settings.heartbeat_ms);
  options.openers = kOpeners;
  options.log_jobs = true;
  return options;
}

void watch_levels(Metrics& metrics, const Settings& settings, const Worker& worker) {
  metrics.watch(Level::jobs_running, [&worker] { return static_cast<double>(worker.running()); });
  metrics.watch(Level::workers, [n = settings.workers] { return static_cast<double>(n); });
}

// Running jobs may end within the grace period; the rest is handed back.
void leave(Worker& worker, milliseconds grace) {
  worker.drain();
  const auto end = Clock::now() + grace;
  while (worker.held() > 0 && Clock::now() < end && wait_for_signal(kLook) != Signal::end) continue;
  worker.stop();
}

}  // namespace

Result<Done> run_worker_until_signal(const Settings& settings, const std::vector<std::string>& parser) {
  if (!is_distributed(settings)) {
    return refused(
        "a worker needs a --database that it shares with front ends (MESHGAUGE_DATABASE); without one "
        "`meshgauge serve` does all by itself");
  }
  if (auto ok = check_reach(settings); !ok) return ok.error();
  if (auto ok = check_descriptors(settings); !ok) return ok.error();
  set_up_process(settings);
  sandbox::Pool pool(pool_settings(settings, parser), [](const std::string& detail) { log_event("sandbox", detail); });
  const auto lacks = pool.start();
  if (!lacks) return lacks.error();
  auto opened = open_stores(settings);
  if (!opened) return opened.error();
  MeshCache cache(settings.max_cache_bytes);
  const Stores stores = stores_of(**opened, cache, nullptr);
  Metrics metrics;
  StoreErrors store_errors(metrics, stores.place);
  ThreadBudget threads(settings.workers);
  MemoryBudget memory(memory_for_meshes(settings));
  CachingMeshLoader loader(pool, cache, read_limits(settings));
  const Measuring measuring(settings, loader, metrics, threads, memory, stores.jobs);
  Scheduler scheduler({settings.workers, 0, std::numeric_limits<std::size_t>::max()});
  Worker worker(settings, stores, measuring, scheduler, store_errors, metrics, options_of(settings));
  Readiness readiness;
  readiness.add_store_checks(stores);
  readiness.add_check("sandbox", [&pool] { return defect_of(pool); });
  metrics.watch_sandbox([&pool] { return pool.counters(); });
  watch_memory(metrics, memory);
  watch_cache(metrics, cache, settings.max_cache_bytes);
  watch_levels(metrics, settings, worker);
  Access access(settings.keys_file);
  const Entrance entrance(access, metrics, Cors::parse(settings.cors_origins).value(), origin_check_of(settings));
  auto tls = tls_of(settings);
  if (auto loaded = load_secrets(access, tls); !loaded) return loaded.error();
  std::atomic<bool> leaving{false};
  StatusPort status(settings, metrics, entrance, tls ? &*tls : nullptr, [&](Exchange& exchange) {
    Readiness::Defects now;
    if (leaving.load()) now.emplace_back("service", "the worker is shutting down");
    readiness.answer(exchange, std::move(now));
  });
  metrics.watch(Level::connections, [&] { return static_cast<double>(status.guard().connections()); });
  metrics.watch(Level::connections_dropped, [&] { return static_cast<double>(status.guard().dropped()); });
  watch_handshakes(metrics, {&status.guard()});
  const auto port = status.start();
  if (!port) return port.error();
  for (const std::string& lack : *lacks) log_event("sandbox", lack);
  Upkeep upkeep(settings, stores, store_errors);
  const EachSecond upkeep_thread([&upkeep] { upkeep.tick(); });
  stores.signals.listen([&worker](const store::Signal& signal) { worker.hear(signal); });
  worker.start();
  end_start_without_memory(nullptr);
  log_listening(settings.host + ":" + std::to_string(*port), settings.simd);
  log_event("memory", memory_text(settings));
  log_event("descriptors", descriptors_text(settings));
  for (Signal signal = Signal::none; status.listening() && signal != Signal::end;) {
    signal = wait_for_signal(kLook);
    if (signal == Signal::reload) reload_secrets(access, tls);
  }
  const bool failed = !status.listening();  // the process ends, so that its supervisor restarts it
  leaving.store(true);
  log_event("stopping", failed ? "the listening socket failed" : "no more jobs are claimed");
  leave(worker, milliseconds(settings.grace_ms));
  stores.signals.stop_listening();
  log_event("sandbox", to_string(pool.counters()));
  log_event("stopped", worker.held() == 0
                           ? "every job is stored or handed back"
                           : "some jobs could not be handed back; they are requeued when their leases expire");
  if (failed) return Error{ErrorCode::internal, "the listening socket failed", "", ""};
  return Done{};
}

}  // namespace meshgauge::server
