#include "server/main/checked.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "api/base/machine.h"
#include "api/base/refused.h"
#include "server/http/origins.h"
#include "server/store/conninfo.h"

namespace meshgauge::server {
namespace {

constexpr std::uint64_t kMostThreads = 4096;
constexpr unsigned kProcessorsPerHandshakeThread = 4;

constexpr std::uint64_t kMostParserMemory = std::uint64_t{1} << 46;
constexpr std::uint64_t kLeastMemory = std::uint64_t{64} << 20;
constexpr std::uint64_t kMostMemory = std::uint64_t{1} << 50;
constexpr std::uint64_t kLeastParserMemory = std::uint64_t{32} << 20;  // a program with no file

// Returns the end of a message: ", not 70000".
std::string not_value(std::uint64_t value) { return ", not " + std::to_string(value); }

// Refuses a setting above `most`, with its value.
Result<Done> check_most(const char* flag, std::uint64_t value, std::uint64_t most) {
  if (value <= most) return Done{};
  return refused(std::string(flag) + " must be at most " + std::to_string(most) + not_value(value));
}

Result<Done> check_threads(const Settings& s) {
  for (const auto& [flag, value] :
       {std::pair("--workers", s.workers), std::pair("--queue", s.queue),
        std::pair("--max-event-streams", s.max_event_streams), std::pair("--io-threads", s.io_threads),
        std::pair("--handshake-threads", s.handshake_threads)}) {
    if (auto ok = check_most(flag, value, kMostThreads); !ok) return ok;
  }
  if (s.io_threads == 0) return refused("--io-threads must be at least 1, not 0");
  return Done{};
}

Result<Done> check_handshakes(const Settings& s) {
  constexpr std::uint64_t kMostPerSecond = 1'000'000;
  for (const auto& [flag, value] :
       {std::pair("--max-handshakes-per-second", s.max_handshakes_per_second),
        std::pair("--max-handshakes-per-second-per-peer", s.max_handshakes_per_second_per_peer)}) {
    if (value >= 1 && value <= kMostPerSecond) continue;
    return refused(std::string(flag) + " must be from 1 to " + std::to_string(kMostPerSecond) + not_value(value));
  }
  return Done{};
}

Result<Done> check_times(const Settings& s) {
  const auto most = static_cast<std::uint64_t>(api::kTimeoutMsRange.high);
  if (s.max_timeout_ms < 1 || s.max_timeout_ms > most) {
    return refused("--max-timeout-ms must be from 1 to " + std::to_string(most) + not_value(s.max_timeout_ms));
  }
  if (s.default_timeout_ms < 1 || s.default_timeout_ms > s.max_timeout_ms) {
    return refused("--default-timeout-ms must be from 1 to --max-timeout-ms (" + std::to_string(s.max_timeout_ms) +
                   ")" + not_value(s.default_timeout_ms));
  }
  constexpr std::uint64_t kHour = 3'600'000;
  constexpr std::uint64_t kCentury = 3'155'760'000;  // s; times are kept in ms, and must not overflow
  for (const auto& [flag, value, limit] :
       {std::tuple("--head-timeout-ms", s.head_timeout_ms, kHour),
        std::tuple("--body-timeout-ms", s.body_timeout_ms, kHour),
        std::tuple("--keep-alive-ms", s.keep_alive_ms, kHour), std::tuple("--grace-ms", s.grace_ms, kHour),
        std::tuple("--result-ttl-s", s.result_ttl_s, kCentury), std::tuple("--mesh-ttl-s", s.mesh_ttl_s, kCentury)}) {
    if (auto ok = check_most(flag, value, limit); !ok) return ok;
  }
  return Done{};
}

Result<Done> check_parsers(const Settings& s) {
  if (auto ok = check_most("--parsers", s.parsers, kMostThreads); !ok) return ok;
  if (s.parser_memory_bytes >= kLeastParserMemory && s.parser_memory_bytes <= kMostParserMemory) return Done{};
  return refused("--parser-memory-bytes must be from " + std::to_string(kLeastParserMemory) + " to " +
                 std::to_string(kMostParserMemory) + not_value(s.parser_memory_bytes));
}

Result<Done> check_memory(const Settings& s) {
  if (s.max_memory_bytes >= kLeastMemory && s.max_memory_bytes <= kMostMemory) return Done{};
  return refused("--max-memory-bytes must be from " + std::to_string(kLeastMemory) + " to " +
                 std::to_string(kMostMemory) + not_value(s.max_memory_bytes));
}

bool is_bucket(std::string_view url) {
  constexpr std::string_view kScheme = "s3://";
  constexpr std::size_t kLeast = 3, kMost = 63;  // bytes of a name
  if (!url.starts_with(kScheme)) return false;
  const std::string_view name = url.substr(kScheme.size(), url.find('/', kScheme.size()) - kScheme.size());
  return name.size() >= kLeast && name.size() <= kMost && std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
         });
}

// Messages do not show the connection string, which may hold a password.
Result<Done> check_database(const Settings& s) {
  if (s.database.empty())
    return s.blobs.empty() ? Result<Done>(Done{})
                           : refused("--blobs needs --database: without it meshes are kept in --data-dir");
  if (!store::is_conninfo(s.database)) {
    return refused("--database must be a PostgreSQL connection string, such as postgresql://USER@HOST/NAME");
  }
  if (!s.blobs.empty() && !is_bucket(s.blobs))
    return refused("--blobs must be s3://BUCKET or s3://BUCKET/PREFIX, not '" + s.blobs + "'");
  if (!s.s3_endpoint.empty() && !s.s3_endpoint.starts_with("http://") && !s.s3_endpoint.starts_with("https://")) {
    return refused("--s3-endpoint must begin with https:// or http://");
  }
  if (s.s3_region.empty()) return refused("--s3-region must not be empty");
  return Done{};
}

Result<Done> check_leases(const Settings& s) {
  constexpr std::uint64_t kHour = 3'600'000;
  if (s.heartbeat_ms < 1 || s.heartbeat_ms > kHour || s.lease_ms > kHour || s.lease_ms < 2 * s.heartbeat_ms) {
    return refused("--heartbeat-ms must be at least 1, and --lease-ms from twice --heartbeat-ms to " +
                   std::to_string(kHour) + ", not " + std::to_string(s.heartbeat_ms) + " and " +
                   std::to_string(s.lease_ms));
  }
  constexpr std::uint64_t kMostPairs = 100'000;
  if (s.max_batch_pairs >= 1 && s.max_batch_pairs <= kMostPairs) return Done{};
  return refused("--max-batch-pairs must be from 1 to " + std::to_string(kMostPairs) + not_value(s.max_batch_pairs));
}

}  // namespace

Result<Settings> checked(Settings s) {
  for (const auto& [flag, port] : {std::pair("--port", s.port), std::pair("--status-port", s.status_port)}) {
    if (auto ok = check_most(flag, port, std::numeric_limits<std::uint16_t>::max()); !ok) return ok.error();
  }
  if (s.tls_certificate.empty() != s.tls_key.empty())
    return refused("--tls-certificate and --tls-key must be given together");
  if (const auto cors = Cors::parse(s.cors_origins); !cors) return cors.error();
  if (const auto hosts = OriginCheck::parse(s.allowed_hosts, OriginCheck::Hosts::listed, {}); !hosts)
    return hosts.error();
  if (s.workers == 0) s.workers = api::processors();
  if (s.handshake_threads == 0) s.handshake_threads = std::max(1U, api::processors() / kProcessorsPerHandshakeThread);
  if (auto ok = check_threads(s); !ok) return ok.error();
  if (auto ok = check_handshakes(s); !ok) return ok.error();
  if (auto ok = check_times(s); !ok) return ok.error();
  if (s.parsers == 0) s.parsers = s.workers + kGuests;
  plan_memory(machine_memory(s.temp_dir), s);
  if (auto ok = check_memory(s); !ok) return ok.error();
  if (auto ok = check_parsers(s); !ok) return ok.error();
  if (auto ok = check_database(s); !ok) return ok.error();
  if (auto ok = check_leases(s); !ok) return ok.error();
  if (s.max_part_bytes > s.max_request_bytes)
    return refused("--max-part-bytes (" + std::to_string(s.max_part_bytes) + ") must be at most --max-request-bytes (" +
                   std::to_string(s.max_request_bytes) + ")");
  const auto simd = api::as_simd(s.simd, "--simd");
  if (!simd) return simd.error();
  s.simd = *simd;
  if (s.log_requests != "all" && s.log_requests != "problems" && s.log_requests != "none") {
    return refused("--log-requests must be all, problems or none, not '" + s.log_requests + "'");
  }
  return s;
}

}  // namespace meshgauge::server
