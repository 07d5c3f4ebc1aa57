// The metrics behind GET /metrics. Counters and histograms are updated where the event occurs; levels are read from
// their owners on scrape. docs/operations.md lists them all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "api/compare/compare.h"
#include "api/map/deviation_map.h"
#include "server/sandbox/pool.h"

namespace meshgauge::server {

struct RequestEnd {
  std::string_view route;  // the template that matched, never the path: clients can invent any number of paths
  std::string_view method;
  int status = 0;
  std::string_view problem;  // its type; empty for a result
  double seconds = 0;        // from the complete head to the last byte of the response
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
};

// missing: no key. malformed: Authorization holds no bearer token. unknown: unknown, expired or disabled. forbidden:
// the key lacks the scope.
enum class AuthFailure { missing, malformed, unknown, forbidden };
enum class StoreFailure { full, unavailable, broken };

// Values that are read on scrape. A level without watch() is not shown.
enum class Level {
  queue_depth,
  queue_limit,
  jobs_running,
  workers,
  connections,
  connections_dropped,
  tls_handshakes,
  tls_handshakes_refused,
  tls_handshakes_abandoned,
  upload_bytes,
  upload_limit_bytes,
  memory_reserved_bytes,
  memory_limit_bytes,
  mesh_cache_hits,
  mesh_cache_misses,
  mesh_cache_bytes,
  mesh_cache_limit_bytes,
  mesh_cache_meshes,
  map_cache_bytes,
  map_cache_limit_bytes,
  map_cache_files,
  event_streams,
  store_queue_depth,
  store_oldest_waiting_seconds,
  deliveries_waiting,
  stored_bytes,
  disk_free_bytes,
};

// Thread safe, except watch() and watch_sandbox(). Counting takes about a microsecond.
class Metrics {
 public:
  Metrics();
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  void request_ended(const RequestEnd& request);

  void job_started(double waited_seconds);
  void job_ended(const api::Comparison& comparison);                  // ended with an interval, complete or not
  void job_failed(std::string_view problem_type, Strategy strategy);  // ended without an interval
  void job_cancelled_early(Strategy strategy);                        // cancelled in the queue or while reading meshes

  void map_found();                                              // a deviation map was served from the cache
  void map_ended(api::MapKind kind, bool made, double seconds);  // `made` false: it failed

  void worker_claimed(std::size_t jobs);
  void worker_lease_lost();  // a job that this process runs was given to another worker

  void auth_failed(AuthFailure why);
  void store_failed(StoreFailure why);

  // Sets the function that reads a level. Call before the first text(). text() calls it on its own thread; it must stay
  // callable until the last text().
  void watch(Level level, std::function<double()> read);
  void watch_sandbox(std::function<sandbox::Counters()> read);

  // Returns all metrics in Prometheus' text format, version 0.0.4.
  std::string text() const;
  static constexpr const char* kContentType = "text/plain; version=0.0.4; charset=utf-8";

 private:
  struct Series;
  std::unique_ptr<Series> series_;
};

}  // namespace meshgauge::server
