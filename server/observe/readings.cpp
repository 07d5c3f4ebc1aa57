#include "server/observe/readings.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/hausdorff.h"
#include "server/observe/log.h"

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
    {"meshgauge_tls_handshakes_total", "TLS handshakes whose costly step was taken", MetricType::Counter},
    {"meshgauge_tls_handshakes_refused_total", "TLS connections closed for the rate of their address or of all",
     MetricType::Counter},
    {"meshgauge_tls_handshakes_abandoned_total", "TLS connections whose client had gone before the costly step",
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

// Resource usage of this process, as the kernel reports it. A field is 0 if /proc does not have it.
struct ProcessFacts {
  std::uint64_t resident_bytes = 0;
  std::uint64_t virtual_bytes = 0;
  std::uint64_t open_descriptors = 0;
  std::uint64_t most_descriptors = 0;  // the limit RLIMIT_NOFILE
  std::uint64_t threads = 0;
  double cpu_seconds = 0;  // of all threads, user and system
  double started = 0;      // seconds since 1970
};

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// The fields of /proc/self/stat from the third on: the second is the program's name, which may hold anything.
std::vector<std::string> stat_fields() {
  std::ifstream file("/proc/self/stat");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  std::istringstream rest(text.substr(text.rfind(')') + 1));
  return {std::istream_iterator<std::string>(rest), {}};
}

std::uint64_t number(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 10); }

void read_stat(ProcessFacts& facts) {
  const auto fields = stat_fields();
  constexpr std::size_t kThreads = 17, kVirtual = 20, kResident = 21;  // proc(5), less three
  if (fields.size() <= kResident) return;
  facts.threads = number(fields[kThreads]);
  facts.virtual_bytes = number(fields[kVirtual]);
  facts.resident_bytes = number(fields[kResident]) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

const auto kStarted = std::chrono::system_clock::now();  // before main()

ProcessFacts process_facts() {
  ProcessFacts facts;
  facts.started = std::chrono::duration<double>(kStarted.time_since_epoch()).count();
  read_stat(facts);
  std::error_code error;
  const std::filesystem::directory_iterator open("/proc/self/fd", error);
  // Less the descriptor of the iterator itself.
  if (!error) facts.open_descriptors = static_cast<std::uint64_t>(std::distance(begin(open), end(open))) - 1;
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0) facts.most_descriptors = limit.rlim_cur;
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) == 0)
    facts.cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  return facts;
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
