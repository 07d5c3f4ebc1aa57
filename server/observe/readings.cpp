#include "server/observe/readings.h"

#include <utility>

#include "engine/hausdorff.h"
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

LevelText text_of(Level level) {
  switch (level) {
    case Level::queue_depth:
      return {"meshgauge_queue_depth", "Comparisons that wait for a worker"};
    case Level::queue_limit:
      return {"meshgauge_queue_limit",
              "Comparisons that may be let in beside those that run, awaited and durable ones together"};
    case Level::jobs_running:
      return {"meshgauge_jobs_running", "Comparisons that workers are busy with"};
    case Level::workers:
      return {"meshgauge_workers", "Comparisons that may run at the same time"};
    case Level::connections:
      return {"meshgauge_connections", "Connections that a thread is serving"};
    case Level::connections_dropped:
      return {"meshgauge_connections_dropped_total", "Connections closed without an answer, for want of room",
              MetricType::Counter};
    case Level::upload_bytes:
      return {"meshgauge_upload_bytes", "Bytes of all uploads, received or being measured"};
    case Level::upload_limit_bytes:
      return {"meshgauge_upload_limit_bytes", "Most that they may be"};
    case Level::mesh_cache_hits:
      return {"meshgauge_mesh_cache_hits_total", "Meshes found in the cache, with their tree", MetricType::Counter};
    case Level::mesh_cache_misses:
      return {"meshgauge_mesh_cache_misses_total", "Meshes that had to be read and built", MetricType::Counter};
    case Level::mesh_cache_bytes:
      return {"meshgauge_mesh_cache_bytes", "Memory of the meshes and trees that are kept"};
    case Level::mesh_cache_limit_bytes:
      return {"meshgauge_mesh_cache_limit_bytes", "Most that they may take"};
    case Level::mesh_cache_meshes:
      return {"meshgauge_mesh_cache_meshes", "Meshes that are kept, with their tree"};
    case Level::map_cache_bytes:
      return {"meshgauge_map_cache_bytes", "Bytes on disk of the deviation maps that are kept"};
    case Level::map_cache_limit_bytes:
      return {"meshgauge_map_cache_limit_bytes", "Most that they may be"};
    case Level::map_cache_files:
      return {"meshgauge_map_cache_files", "Deviation maps that are kept"};
    case Level::event_streams:
      return {"meshgauge_event_streams", "Clients that follow a comparison's events"};
    case Level::store_queue_depth:
      return {"meshgauge_store_queue_depth", "Comparisons of all front ends that wait for a worker"};
    case Level::store_oldest_waiting_seconds:
      return {"meshgauge_store_oldest_waiting_seconds", "How long the oldest of them has waited"};
    case Level::deliveries_waiting:
      return {"meshgauge_worker_deliveries_waiting", "Ends of jobs on their way into the store"};
    case Level::stored_bytes:
      return {"meshgauge_stored_bytes", "Bytes of the meshes in the store"};
    case Level::disk_free_bytes:
      return {"meshgauge_disk_free_bytes", "Free bytes of the file system that holds the store"};
  }
  return {};
}

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
      family({"meshgauge_sandbox_workers_started_total", "Processes made to read uploads", MetricType::Counter},
             count(counters.started)));
  const std::pair<const char*, std::uint64_t> outcomes[] = {
      {"read", counters.read},       {"out_of_memory", counters.out_of_memory},
      {"crashed", counters.crashed}, {"untrue", counters.untrue},
      {"overdue", counters.overdue}, {"cancelled", counters.cancelled}};
  MetricFamily ended{
      "meshgauge_sandbox_workers_ended_total", "How those that were given a file ended", MetricType::Counter, {}};
  for (const auto& [outcome, n] : outcomes) {
    ended.metric.push_back(sample(MetricType::Counter, count(n), {{"outcome", outcome}}));
  }
  families.push_back(std::move(ended));
}

// Names and meanings that every Prometheus client has.
void append_process(const ProcessFacts& facts, std::vector<MetricFamily>& families) {
  const auto add = [&](const LevelText& text, auto value) {
    families.push_back(family(text, static_cast<double>(value)));
  };
  add({"process_cpu_seconds_total", "Processor time of the service, without the processes that read uploads",
       MetricType::Counter},
      facts.cpu_seconds);
  add({"process_start_time_seconds", "When the service started, in seconds since 1970"}, facts.started);
  add({"process_resident_memory_bytes", "Memory of the service, without the processes that read uploads"},
      facts.resident_bytes);
  add({"process_virtual_memory_bytes", "Address space of the service"}, facts.virtual_bytes);
  add({"process_open_fds", "Open descriptors of the service"}, facts.open_descriptors);
  add({"process_max_fds", "Most descriptors that the service may open"}, facts.most_descriptors);
  add({"process_threads", "Threads of the service"}, facts.threads);
}

}  // namespace

void Readings::append_to(std::vector<MetricFamily>& families) const {
  for (const auto& [level, read] : levels_) families.push_back(family(text_of(level), read()));
  if (sandbox_) append_sandbox(sandbox_(), families);
  append_process(process_facts(), families);
  families.push_back({"meshgauge_build_info",
                      "1, with the version that runs",
                      MetricType::Gauge,
                      {sample(MetricType::Gauge, 1, {{"version", version()}})}});
}

}  // namespace meshgauge::server
