#include "server/observe/readings.h"

#include <iterator>
#include <utility>

#include "engine/hausdorff.h"
#include "server/observe/log.h"
#include "server/observe/process.h"

namespace meshgauge::server {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using prometheus::MetricType;

struct LevelText {
  const char* name;
  const char* help;
  MetricType type = MetricType::Gauge;
};

// In the order of Level.
constexpr LevelText kLevels[] = {
    {"meshgauge_queue_depth", "Jobs that wait for a thread of this process, without those that wait in a database"},
    {"meshgauge_queue_limit", "Limit of queued comparisons, awaited and durable ones together"},
    {"meshgauge_jobs_running", "Jobs that run in this process"},
    {"meshgauge_workers", "Jobs that may run in this process at the same time"},
    {"meshgauge_connections", "Connections being served"},
    {"meshgauge_connections_dropped_total", "Connections closed without a response, all threads and queues being full",
     MetricType::Counter},
    {"meshgauge_upload_bytes", "Bytes of all uploads being received or measured"},
    {"meshgauge_upload_limit_bytes", "Limit of meshgauge_upload_bytes"},
    {"meshgauge_memory_reserved_bytes", "Memory that comparisons and reader processes have reserved"},
    {"meshgauge_memory_limit_bytes", "Limit of meshgauge_memory_reserved_bytes"},
    {"meshgauge_mesh_cache_hits_total", "Meshes found in the cache, with their tree", MetricType::Counter},
    {"meshgauge_mesh_cache_misses_total", "Meshes that had to be read and built", MetricType::Counter},
    {"meshgauge_mesh_cache_bytes", "Memory of cached meshes and their trees"},
    {"meshgauge_mesh_cache_limit_bytes", "Limit of meshgauge_mesh_cache_bytes"},
    {"meshgauge_mesh_cache_meshes", "Cached meshes"},
    {"meshgauge_map_cache_bytes", "Bytes on disk of cached deviation maps"},
    {"meshgauge_map_cache_limit_bytes", "Limit of meshgauge_map_cache_bytes"},
    {"meshgauge_map_cache_files", "Cached deviation maps"},
    {"meshgauge_event_streams", "Clients that hold a connection to follow events or to wait for a result"},
    {"meshgauge_store_queue_depth", "Comparisons of all front ends that wait for a worker"},
    {"meshgauge_store_oldest_waiting_seconds", "Age of the oldest of them"},
    {"meshgauge_worker_deliveries_waiting", "Results of this worker that are not stored yet"},
    {"meshgauge_stored_bytes", "Bytes of the meshes in the store"},
    {"meshgauge_disk_free_bytes", "Free bytes of the file system that holds the store"}};
static_assert(std::size(kLevels) == static_cast<std::size_t>(Level::disk_free_bytes) + 1);

ClientMetric sample(MetricType type, double value, std::vector<ClientMetric::Label> labels = {}) {
  ClientMetric metric;
  metric.label = std::move(labels);
  (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return metric;
}

MetricFamily family(const LevelText& text, double value) {
  return {text.name, text.help, text.type, {sample(text.type, value)}};
}

void append_sandbox(const sandbox::Counters& counters, std::vector<MetricFamily>& families) {
  const auto count = [](std::uint64_t n) { return static_cast<double>(n); };
  families.push_back(
      family({"meshgauge_sandbox_workers_started_total", "Reader processes started", MetricType::Counter},
             count(counters.started)));
  MetricFamily ended{"meshgauge_sandbox_workers_ended_total",
                     "Reader processes that were given a file, by outcome",
                     MetricType::Counter,
                     {}};
  for (std::size_t end = 0; end < sandbox::kEndNames.size(); ++end) {
    const std::string outcome(sandbox::kEndNames[end]);
    ended.metric.push_back(sample(MetricType::Counter, count(counters.ended[end]), {{"outcome", outcome}}));
  }
  families.push_back(std::move(ended));
}

// The standard metrics of Prometheus' client libraries.
void append_process(const ProcessFacts& facts, std::vector<MetricFamily>& families) {
  const auto add = [&](const LevelText& text, auto value) {
    families.push_back(family(text, static_cast<double>(value)));
  };
  add({"process_cpu_seconds_total", "Processor time of the service, without its reader processes", MetricType::Counter},
      facts.cpu_seconds);
  add({"process_start_time_seconds", "Start of the service, in seconds since 1970"}, facts.started);
  add({"process_resident_memory_bytes", "Memory of the service, without its reader processes"}, facts.resident_bytes);
  add({"process_virtual_memory_bytes", "Address space of the service"}, facts.virtual_bytes);
  add({"process_open_fds", "Open file descriptors of the service"}, facts.open_descriptors);
  add({"process_max_fds", "Limit of open file descriptors"}, facts.most_descriptors);
  add({"process_threads", "Threads of the service"}, facts.threads);
}

}  // namespace

void Readings::append_to(std::vector<MetricFamily>& families) const {
  for (const auto& [level, read] : levels_)
    families.push_back(family(kLevels[static_cast<std::size_t>(level)], read()));
  if (sandbox_) append_sandbox(sandbox_(), families);
  families.push_back(
      family({"meshgauge_log_lines_dropped_total", "Lines that the log's reader was too slow for", MetricType::Counter},
             static_cast<double>(log_lines_dropped())));
  append_process(process_facts(), families);
  families.push_back({"meshgauge_build_info",
                      "Always 1; the label has the running version",
                      MetricType::Gauge,
                      {sample(MetricType::Gauge, 1, {{"version", version()}})}});
}

}  // namespace meshgauge::server
