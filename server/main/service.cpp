#include "server/main/service.h"

#include <thread>

#include "server/base/heap.h"
#include "server/handlers/problems.h"
#include "server/http/descriptors.h"
#include "server/main/wiring.h"
#include "server/measure/caching_mesh_loader.h"
#include "server/measure/map_cache.h"
#include "server/observe/log.h"
#include "server/sandbox/pool.h"
#include "server/web/pages.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kServiceTick{50};

// Cached maps leave map_cache_room_bytes free on the disk, for uploads and results.
MapCache::Settings map_settings(const Settings& settings, const std::string& data_folder) {
  const std::string folder = data_folder + "/maps";
  return {folder, settings.map_cache_bytes, settings.temp_dir,
          [folder, wanted = settings.map_cache_room_bytes] { return lacking_bytes_on(folder, wanted); }};
}

}  // namespace

Service::Service(const Settings& settings, MeshLoader& loader, const Stores& stores)
    : settings_(settings),
      stores_(stores),
      access_(settings.keys_file),
      entrance_(access_, metrics_, Cors::parse(settings.cors_origins).value(), origin_check_of(settings)),
      tls_(tls_of(settings)),
      uploads_(settings.max_upload_bytes),
      jobs_(settings, loader, stores, access_, metrics_),
      comparisons_(settings, jobs_, stores, access_, uploads_),
      meshes_(settings, stores, access_, uploads_),
      requests_(entrance_, router_, settings_, metrics_),
      guard_(settings, requests_, tls_ ? &*tls_ : nullptr, plan_descriptors(settings).connections),
      listener_([this] { guard_.abort(); }) {
  if (stores.maps) deviations_.emplace(settings, jobs_, stores, access_, metrics_, loader);
  readiness_.add_store_checks(stores_);
  readiness_.add_check(
      "disk", [this] { return why_no_upload(settings_.temp_dir); }, "--temp-dir '" + settings_.temp_dir + "'");
  if (stores.batches) batches_.emplace(settings, jobs_, stores, access_, uploads_, comparisons_.watchers());
  if (settings.status_port > 0) {
    Settings second = settings;
    second.port = settings.status_port;
    status_.emplace(second, metrics_, entrance_, tls_ ? &*tls_ : nullptr, [this](Exchange& e) { check_ready(e); });
  }
  add_routes();
  watch_levels();
}

Service::~Service() {
  shutdown([] { return true; });
}

void Service::add_routes() {
  add_page_routes();
  add_status_routes(router_, metrics_, [this](Exchange& e) { check_ready(e); });
  add_comparison_routes();
  add_batch_routes();
  add_listing_routes();
  router_.add("POST", "/v1/meshes", [this](Exchange& e) { meshes_.post(e); });
  router_.add("PUT", "/v1/meshes/{}", [this](Exchange& e) { meshes_.put(e); });
  router_.add("GET", "/v1/meshes/{}", [this](Exchange& e) { meshes_.get(e); });
  router_.add("DELETE", "/v1/meshes/{}", [this](Exchange& e) { meshes_.remove(e); });
}

// Pages ignore a query: a link may have got one on its way.
void Service::add_page_routes() {
  const auto add = [this](const char* path, Router::Action action) {
    router_.add("GET", path, std::move(action)).takes_query = true;
  };
  add("/", show_root);
  for (const char* page : {"/b/{}", "/c/{}"}) add(page, show_permanent_link);
  for (const char* damaged : {"/b", "/b/", "/b/{}/", "/c", "/c/", "/c/{}/"}) add(damaged, show_damaged_link);
  add("/page/{}", send_page_file);
  add("/openapi.yaml", send_description);
  add("/gates.schema.json", send_gates_schema);
  add("/problems", list_problems);
  add("/problems/{}", show_problem);
  add("/docs", show_reference);
  add("/docs/{}", send_reference_file);
}

void Service::add_comparison_routes() {
  router_.add("POST", "/v1/comparisons", [this](Exchange& e) { comparisons_.create(e); }).refuse = [this](Exchange& e) {
    comparisons_.refuse(e);
  };
  router_.add("GET", "/v1/comparisons/{}", [this](Exchange& e) { comparisons_.get(e); });
  router_.add("DELETE", "/v1/comparisons/{}", [this](Exchange& e) { comparisons_.remove(e); });
  router_.add("POST", "/v1/comparisons/{}/cancel", [this](Exchange& e) { comparisons_.cancel(e); });
  router_.add("GET", "/v1/comparisons/{}/events", [this](Exchange& e) { comparisons_.events(e); });
  router_.add("POST", "/v1/options", [this](Exchange& e) { read_options(e, settings_); });
  if (!deviations_) return;
  for (const auto& format : api::kMapFormats) {
    Router::Route& route = router_.add("GET", "/v1/comparisons/{}/deviation." + std::string(format.name),
                                       [this, kind = format.kind](Exchange& e) { deviations_->get(e, kind); });
    route.takes_query = true;
  }
}

void Service::add_batch_routes() {
  if (!batches_) return;
  router_.add("POST", "/v1/batches", [this](Exchange& e) { batches_->create(e, comparisons_.refusing()); });
  router_.add("GET", "/v1/batches/{}", [this](Exchange& e) { batches_->get(e); });
  router_.add("DELETE", "/v1/batches/{}", [this](Exchange& e) { batches_->remove(e); });
  router_.add("POST", "/v1/batches/{}/cancel", [this](Exchange& e) { batches_->cancel(e); });
  router_.add("GET", "/v1/batches/{}/events", [this](Exchange& e) { batches_->events(e); });
  router_.add("GET", "/v1/batches/{}/results.jsonl", [this](Exchange& e) { batches_->results(e); });
  router_.add("GET", "/v1/batches/{}/junit.xml", [this](Exchange& e) { batches_->junit(e); });
}

void Service::add_listing_routes() {
  if (!stores_.listings || !stores_.batches) return;
  listings_.emplace(settings_, stores_, access_);
  router_.add("GET", "/v1/meshes", [this](Exchange& e) { listings_->meshes(e); }).takes_query = true;
  router_.add("GET", "/v1/comparisons", [this](Exchange& e) { listings_->comparisons(e); }).takes_query = true;
  router_.add("GET", "/v1/batches", [this](Exchange& e) { listings_->batches(e); }).takes_query = true;
}

void Service::watch_levels() {
  const auto watch = [this](Level level, auto read) {
    metrics_.watch(level, [read] { return static_cast<double>(read()); });
  };
  watch(Level::queue_depth, [this] { return jobs_.waiting(); });
  watch(Level::queue_limit, [this] { return settings_.queue + settings_.max_queued_jobs; });
  watch(Level::jobs_running, [this] { return jobs_.figures().running; });
  watch(Level::workers, [this] { return settings_.workers; });
  watch(Level::connections, [this] { return guard_.connections(); });
  watch(Level::connections_dropped, [this] { return guard_.dropped(); });
  std::vector<const HttpGuard*> guards{&guard_};
  if (status_) guards.push_back(&status_->guard());
  watch_handshakes(metrics_, guards);
  watch(Level::upload_bytes, [this] { return uploads_.used(); });
  watch(Level::upload_limit_bytes, [this] { return uploads_.max_bytes(); });
  watch_memory(metrics_, jobs_.memory());
  watch_cache(metrics_, stores_.cache, settings_.max_cache_bytes);
  if (stores_.maps) {
    watch(Level::map_cache_bytes, [this] { return stores_.maps->counters().bytes; });
    watch(Level::map_cache_limit_bytes, [this] { return settings_.map_cache_bytes; });
    watch(Level::map_cache_files, [this] { return stores_.maps->counters().files; });
  }
  watch(Level::event_streams, [this] { return comparisons_.watcher_count(); });
  const auto or_none = [](const Result<std::uint64_t>& bytes) { return bytes ? *bytes : 0; };
  watch(Level::stored_bytes, [this, or_none] { return or_none(stores_.meshes.all_stored_bytes()); });
  if (stores_.shared) {
    watch(Level::store_queue_depth, [this] { return jobs_.store_queue()->counts().queued; });
    watch(Level::store_oldest_waiting_seconds, [this] { return jobs_.store_queue()->oldest_waiting_seconds(); });
  }
  // Shared stores cannot tell.
  if (!stores_.shared) watch(Level::disk_free_bytes, [this, or_none] { return or_none(stores_.blobs.free_bytes()); });
}

void Service::check_ready(Exchange& exchange) {
  Readiness::Defects now;
  if (!listening() || comparisons_.refusing()) now.emplace_back("service", "the service is shutting down");
  if (!jobs_.has_place_for_new_client(Jobs::Kind::awaited)) now.emplace_back("queue", "the queue is full");
  if (!jobs_.has_place_for_new_client(Jobs::Kind::durable)) {
    now.emplace_back("queue", "the queue of durable comparisons is full");
  }
  readiness_.answer(exchange, std::move(now));
}

Result<int> Service::start() {
  if (auto ok = check_temp_dir(settings_.temp_dir); !ok) return ok.error();
  if (auto ok = load_secrets(access_, tls_); !ok) return ok.error();
  const auto port = bind(guard_, settings_);
  if (!port) return port.error();
  if (status_) {
    if (const auto second = status_->start(); !second) return second.error();
  }
  if (auto ok = jobs_.recover(); !ok) return ok.error();
  ended_.store(false);
  listener_.start([this] {
    guard_.run();
    ended_.store(true);
  });
  return *port;
}

void Service::reload() { reload_secrets(access_, tls_); }

void Service::shutdown(const std::function<bool()>& give_up) {
  if (listener_.empty()) return;
  comparisons_.refuse_new();
  jobs_.drain();
  guard_.stop();
  // Durable jobs may run without a connection, so their end is awaited as well.
  while ((!ended_.load() || jobs_.figures().running > 0) && !give_up()) std::this_thread::sleep_for(kServiceTick);
  jobs_.stop();
  listener_.end();
}

Result<Done> run_until_signal(const Settings& settings, const std::vector<std::string>& parser) {
  if (auto ok = check_reach(settings); !ok) return ok.error();
  if (auto ok = check_descriptors(settings); !ok) return ok.error();
  set_up_process(settings);
  sandbox::Pool pool(pool_settings(settings, parser), [](const std::string& detail) { log_event("sandbox", detail); });
  const auto lacks = pool.start();
  if (!lacks) return lacks.error();
  auto stores = open_stores(settings);
  if (!stores) return stores.error();
  MeshCache cache(settings.max_cache_bytes);
  MapCache maps(map_settings(settings, (*stores)->data_folder()));
  if (auto opened = maps.open(); !opened) return opened.error();
  CachingMeshLoader loader(pool, cache, read_limits(settings));
  Service service(settings, loader, stores_of(**stores, cache, &maps));
  service.metrics().watch_sandbox([&pool] { return pool.counters(); });
  service.readiness().add_check("sandbox", [&pool] { return defect_of(pool); });
  const auto port = service.start();
  if (!port) return port.error();
  end_start_without_memory(nullptr);
  log_listening(settings.host + ":" + std::to_string(*port), settings.simd);
  log_event("memory", memory_text(settings));
  log_event("descriptors", descriptors_text(settings));
  for (const std::string& lack : *lacks) log_event("sandbox", lack);
  if (!settings.keys_file.empty() && settings.tls_certificate.empty()) {
    log_event("access", "keys are sent unencrypted; set tls_certificate, or use a proxy in front that speaks TLS");
  }
  for (Signal signal = Signal::none; service.listening() && signal != Signal::end;) {
    signal = wait_for_signal(kServiceTick);
    if (signal == Signal::reload) service.reload();
  }
  const bool failed = !service.listening();  // exit with an error, so that a supervisor restarts the service
  log_event("stopping", failed ? "the listening socket failed" : "no new work is accepted");
  const auto grace_end = Clock::now() + std::chrono::milliseconds(settings.grace_ms);
  service.shutdown(
      [&] { return Clock::now() >= grace_end || wait_for_signal(std::chrono::milliseconds(0)) == Signal::end; });
  log_event("sandbox", to_string(pool.counters()));
  log_event("stopped", "every request was answered");
  if (failed) return Error{ErrorCode::internal, "the listening socket failed", "", ""};
  return Done{};
}

}  // namespace meshgauge::server
