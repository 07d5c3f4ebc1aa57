// The numbers behind GET /metrics. What happens is told by the one who sees it happen; how things stand is asked of its
// owner when the numbers are read. docs/operations.md lists them all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "api/compare.h"
#include "server/sandbox/pool.h"

namespace meshgauge::server {

struct RequestEnd {
  std::string_view route;  // the template that matched, never the path: anyone can make up paths
  std::string_view method;
  int status = 0;
  std::string_view problem;  // type URN; empty for a result
  double seconds = 0;        // from the head to the last byte of the response
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
};

enum class AuthFailure { missing, malformed, unknown, forbidden };  // no key, not a key, nobody's, not for this
enum class StoreFailure { full, unavailable, broken };

// What is read out. One that nobody watches is not shown.
enum class Level {
  queue_depth,
  queue_limit,
  jobs_running,
  workers,
  connections,
  connections_dropped,
  upload_bytes,
  upload_limit_bytes,
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

// Thread safe; the methods that count take about a microsecond.
class Metrics {
 public:
  Metrics();
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  void request_ended(const RequestEnd& request);

  void job_started(double waited_seconds);
  void job_ended(const api::Comparison& comparison);                  // with an interval, however it ended
  void job_failed(std::string_view problem_type, Strategy strategy);  // without
  void job_cancelled_early(Strategy strategy);                        // in the queue, or while its meshes were read

  void map_found();  // a deviation map that was made before
  void map_ended(std::string_view format, bool made, double seconds);

  void worker_claimed(std::size_t jobs);
  void worker_lease_lost();  // a job that runs here is another worker's by now

  void auth_failed(AuthFailure why);
  void store_failed(StoreFailure why);

  // Both must be set before the first text(), and stay callable until the last; they are called by the thread that asks
  // for the text.
  void watch(Level level, std::function<double()> read);
  void watch_sandbox(std::function<sandbox::Counters()> read);

  // Prometheus' text format, version 0.0.4.
  std::string text() const;
  static constexpr const char* kContentType = "text/plain; version=0.0.4; charset=utf-8";

 private:
  struct Series;
  std::unique_ptr<Series> series_;
};

}  // namespace meshgauge::server
