#include "server/main/wiring.h"

#include <signal.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "api/base/descriptor.h"
#include "api/base/digest.h"
#include "api/base/refused.h"
#include "server/base/heap.h"
#include "server/http/upload.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kReaderTime{1000};  // to wait for a reader, before the service is not ready

sigset_t awaited_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGHUP);
  return set;
}

// A SIGHUP from the kernel means that the terminal was closed. Under nohup the service ignores it.
Signal meaning_of_hangup(const siginfo_t& info) {
  if (info.si_code != SI_KERNEL) return Signal::reload;
  struct sigaction started {};
  ::sigaction(SIGHUP, nullptr, &started);
  return started.sa_handler == SIG_IGN ? Signal::none : Signal::end;
}

bool may_be_public(const Settings& settings) { return !settings.keys_file.empty() || settings.public_without_keys; }

Error public_without_leave(const Settings& settings) {
  return refused("other machines can reach " + settings.host +
                 ": give --keys-file, or --public-without-keys to serve every client without a key "
                 "(MESHGAUGE_KEYS_FILE, MESHGAUGE_PUBLIC_WITHOUT_KEYS=true)");
}

void report(const std::string& line) { log_event("store", line); }

// The outages of a database name its host themselves.
std::string in_folder(const store::AllStores& all) {
  return all.shared() ? "" : "in the data folder '" + all.data_folder() + "'";
}

store::DistributedSettings distributed(const Settings& settings) {
  store::DistributedSettings asked;
  asked.database = settings.database;
  asked.blobs = settings.blobs;
  asked.s3_endpoint = settings.s3_endpoint;
  asked.s3_region = settings.s3_region;
  asked.s3_virtual_host = settings.s3_virtual_host;
  asked.blob_cache_bytes = settings.blob_cache_bytes;
  asked.data_folder = settings.data_dir;
  asked.report = report;
  return asked;
}

}  // namespace

void set_up_process(const Settings& settings) {
  const sigset_t signals = awaited_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  ::signal(SIGXFSZ, SIG_IGN);
  keep_heap_small(static_cast<unsigned>(settings.workers));
  wait_for_memory();
  api::set_up_digests();
  start_log();
}

Result<std::unique_ptr<store::AllStores>> open_stores(const Settings& settings) {
  if (is_distributed(settings)) return store::AllStores::open_distributed(distributed(settings));
  return store::AllStores::open_embedded({settings.data_dir, store::EmbeddedSettings().max_unrecorded, report});
}

Stores stores_of(store::AllStores& all, MeshCache& cache, MapCache* maps) {
  return {all.jobs(),   all.meshes(), all.blobs(),    all.signals(),   cache,
          all.shared(), maps,         &all.batches(), &all.listings(), in_folder(all)};
}

sandbox::PoolSettings pool_settings(const Settings& settings, const std::vector<std::string>& command) {
  sandbox::Bounds bounds;
  bounds.memory_bytes = settings.parser_memory_bytes;
  bounds.input_bytes = settings.max_part_bytes;
  bounds.cpu_seconds = settings.max_timeout_ms / 1000 + 2;  // a backstop; the deadline comes first
  return {command, settings.parsers, bounds, settings.require_sandbox};
}

std::string defect_of(sandbox::Pool& pool) {
  Control limit;
  limit.set_deadline(Control::Clock::now() + kReaderTime);
  return pool.defect(limit);
}

std::string why_no_upload(const std::string& directory) {
  const Descriptor file(open_unnamed_file(directory));
  return file ? "" : std::string("no file can be created in the directory for uploads: ") + std::strerror(errno);
}

Result<Done> check_temp_dir(const std::string& directory) {
  const std::string defect = why_no_upload(directory);
  if (defect.empty()) return Done{};
  return refused(defect + " (--temp-dir '" + directory + "')");
}

Result<Done> check_reach(const Settings& settings) {
  if (may_be_public(settings) || stands_for_loopback(settings.host)) return Done{};
  return public_without_leave(settings);
}

Result<int> bind(HttpGuard& guard, const Settings& settings) {
  const auto port = guard.bind();
  if (!port) {
    return Error{
        ErrorCode::internal,
        "cannot listen on " + settings.host + ":" + std::to_string(settings.port) + ": " + std::strerror(errno), "",
        ""};
  }
  // By the socket's address: of a host name with several addresses it may be a public one.
  if (may_be_public(settings) || guard.bound_to_loopback()) return *port;
  return public_without_leave(settings);
}

OriginCheck origin_check_of(const Settings& settings) {
  if (!settings.keys_file.empty()) return {};
  const auto hosts = settings.public_without_keys ? OriginCheck::Hosts::any : OriginCheck::Hosts::listed;
  return OriginCheck::parse(settings.allowed_hosts, hosts, Cors::parse(settings.cors_origins).value()).value();
}

std::optional<Tls> tls_of(const Settings& settings) {
  if (settings.tls_certificate.empty()) return std::nullopt;
  return std::optional<Tls>(std::in_place, settings.tls_certificate, settings.tls_key);
}

Result<Done> load_secrets(Access& access, std::optional<Tls>& tls) {
  if (auto loaded = access.reload(); !loaded) return loaded.error();
  if (!tls) return Done{};
  if (auto loaded = tls->reload(); !loaded) return loaded.error();
  return Done{};
}

void reload_secrets(Access& access, std::optional<Tls>& tls) {
  if (access.has_keys()) {
    const auto keys = access.reload();
    log_event("reload",
              keys ? "keys: " + std::to_string(*keys) : keys.error().message + "; the old keys stay in force");
  }
  if (tls) {
    const auto end = tls->reload();
    log_event("reload", end ? "certificate valid until " + *end : end.error().message + "; the old certificate stays");
  }
  if (!access.has_keys() && !tls) log_event("reload", "nothing to reload: neither keys nor a certificate are set");
}

void watch_memory(Metrics& metrics, const MemoryBudget& memory) {
  metrics.watch(Level::memory_reserved_bytes, [&memory] { return static_cast<double>(memory.reserved()); });
  metrics.watch(Level::memory_limit_bytes, [&memory] { return static_cast<double>(memory.bytes()); });
}

void watch_cache(Metrics& metrics, const MeshCache& cache, std::uint64_t max_bytes) {
  const auto watch = [&](Level level, auto read) {
    metrics.watch(level, [&cache, read] { return static_cast<double>(read(cache.counters())); });
  };
  watch(Level::mesh_cache_hits, [](const auto& counters) { return counters.hits; });
  watch(Level::mesh_cache_misses, [](const auto& counters) { return counters.misses; });
  watch(Level::mesh_cache_bytes, [](const auto& counters) { return counters.bytes; });
  watch(Level::mesh_cache_meshes, [](const auto& counters) { return counters.meshes; });
  metrics.watch(Level::mesh_cache_limit_bytes, [max_bytes] { return static_cast<double>(max_bytes); });
}

void watch_handshakes(Metrics& metrics, const std::vector<const HttpGuard*>& guards) {
  const auto watch = [&](Level level, auto read) {
    metrics.watch(level, [guards, read] {
      std::uint64_t sum = 0;
      for (const HttpGuard* guard : guards) sum += read(guard->handshakes());
      return static_cast<double>(sum);
    });
  };
  watch(Level::tls_handshakes, [](const auto& counts) { return counts.begun; });
  watch(Level::tls_handshakes_refused, [](const auto& counts) { return counts.refused; });
  watch(Level::tls_handshakes_abandoned, [](const auto& counts) { return counts.abandoned; });
}

Signal wait_for_signal(std::chrono::milliseconds time) {
  const sigset_t set = awaited_signals();
  const timespec wait{0, time.count() * 1'000'000};
  siginfo_t info{};
  const int signal = sigtimedwait(&set, &info, &wait);
  if (signal <= 0) return Signal::none;
  return signal == SIGHUP ? meaning_of_hangup(info) : Signal::end;
}

}  // namespace meshgauge::server
