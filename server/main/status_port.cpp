#include "server/main/status_port.h"

#include <cstddef>
#include <utility>

#include "server/handlers/readiness.h"
#include "server/http/descriptors.h"
#include "server/main/wiring.h"

namespace meshgauge::server {
namespace {

constexpr const char* kNothing =
    "this port serves /healthz, /readyz and /metrics alone; send requests to the port of a front end (meshgauge serve)";

Settings with_few_threads(Settings settings) {
  settings.io_threads = 1;  // for refusals: the rest has threads of its own
  settings.handshake_threads = 1;
  return settings;
}

// A worker has no other port.
std::size_t connections_of(const Settings& settings) {
  return settings.status_port > 0 ? kStatusConnections : plan_descriptors(settings).connections;
}

}  // namespace

StatusPort::StatusPort(const Settings& settings, Metrics& metrics, const Entrance& entrance, const Tls* tls,
                       Router::Action ready)
    : settings_(with_few_threads(settings)),
      router_(kNothing),
      requests_(entrance, router_, settings_, metrics),
      guard_(settings_, requests_, tls, connections_of(settings)),
      listener_([this] { tell_end(); }) {
  add_status_routes(router_, metrics, std::move(ready));
}

void StatusPort::tell_end() {
  guard_.stop();
  guard_.abort();
}

Result<int> StatusPort::start() {
  const auto port = bind(guard_, settings_);
  if (!port) return port.error();
  ended_.store(false);
  listener_.start([this] {
    guard_.run();
    ended_.store(true);
  });
  return *port;
}

}  // namespace meshgauge::server
