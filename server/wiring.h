// What a front end and a worker are put together from alike: the pool of readers, meshes by it, and
// what a process is told by signals.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/http/http_guard.h"
#include "server/http/tls.h"
#include "server/jobs/measuring.h"
#include "server/jobs/mesh_cache.h"
#include "server/observe/metrics.h"
#include "server/sandbox/pool.h"
#include "server/settings.h"

namespace meshgauge::server {

// Uploads are read by processes that `command` makes: a program and its arguments that calls sandbox::run_spawner().
sandbox::PoolSettings pool_settings(const Settings& settings, const std::vector<std::string>& command);

// Why it cannot read now, or empty: waits for a reader, a second at most.
std::string defect_of(sandbox::Pool& pool);

// Meshes from the pool, those that are stored from the cache. Borrows both.
Fetch fetching_by(sandbox::Pool& pool, MeshCache& cache, const api::ReadLimits& limits);

// An Error when it takes no files.
Result<Done> check_temp_dir(const std::string& directory);

// The port. An Error when there is none, or when other machines can reach it and nobody said that they may.
Result<int> bind(HttpGuard& guard, const Settings& settings);
std::optional<Tls> tls_of(const Settings& settings);  // none: the port speaks plain HTTP

// The end of a request: counted and, as the settings say, logged after its last byte.
void record_request(const Exchange& exchange, const Settings& settings, Metrics& metrics);

void watch_cache(Metrics& metrics, const MeshCache& cache, std::uint64_t max_bytes);  // borrows it

// What a process that serves is told: to end by SIGTERM, SIGINT and the end of its terminal; to read its files anew by
// SIGHUP from anyone else.
enum class Signal { none, end, reload };
void block_signals();  // those, in this thread and those that it starts; first of all
Signal signalled_within(std::chrono::milliseconds time);

}  // namespace meshgauge::server
