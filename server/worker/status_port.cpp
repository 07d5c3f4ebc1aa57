#include "server/worker/status_port.h"

#include <chrono>
#include <utility>

#include "server/wiring.h"

namespace meshgauge::server {
namespace {

constexpr const char* kNothing =
    "this is a worker, which serves /healthz, /readyz and /metrics alone; send requests to a front end (meshgauge "
    "serve)";

constexpr std::uint64_t kThreads = 4;  // for scrapes and probes

Settings with_few_threads(Settings settings) {
  settings.io_threads = kThreads;
  settings.max_arriving_per_peer = kThreads;
  return settings;
}

}  // namespace

StatusPort::StatusPort(const Settings& settings, Metrics& metrics, Readiness& readiness)
    : settings_(with_few_threads(settings)),
      metrics_(metrics),
      readiness_(readiness),
      access_(settings.keys_file),
      entrance_(access_, metrics_, Cors::parse(settings.cors_origins).value()),
      tls_(tls_of(settings)),
      router_(kNothing),
      guard_(
          settings_, [this](Exchange& exchange) { entrance_(exchange, router_); },
          [this](const Exchange& exchange) { record_request(exchange, settings_, metrics_); },
          tls_ ? &*tls_ : nullptr) {
  router_.add("GET", "/healthz", answer_health);
  router_.add("GET", "/readyz", [this](Exchange& e) {
    Readiness::Defects now;
    if (refusing_.load()) now.emplace_back("service", "the worker is shutting down");
    readiness_.answer(e, std::move(now));
  });
  router_.add("GET", "/metrics", [this](Exchange& e) {
    e.response.content_type = Metrics::kContentType;
    e.response.body = metrics_.text();
  });
  metrics_.watch(Level::connections, [this] { return static_cast<double>(guard_.connections()); });
  metrics_.watch(Level::connections_dropped, [this] { return static_cast<double>(guard_.dropped()); });
}

StatusPort::~StatusPort() {
  if (!listener_.joinable()) return;
  guard_.stop();
  guard_.abort();
  listener_.join();
}

Result<int> StatusPort::start() {
  if (auto loaded = access_.reload(); !loaded) return loaded.error();
  if (tls_) {
    if (auto loaded = tls_->reload(); !loaded) return loaded.error();
  }
  const auto port = bind(guard_, settings_);
  if (!port) return port.error();
  ended_.store(false);
  listener_ = std::thread([this] {
    guard_.run();
    ended_.store(true);
  });
  while (!guard_.running() && !ended_.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return *port;
}

}  // namespace meshgauge::server
