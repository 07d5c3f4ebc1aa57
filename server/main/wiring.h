// Parts that `serve` and `worker` set up alike: the process, the stores, the pool of reader processes, the listening
// socket, and signals.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.h"
#include "server/access/access.h"
#include "server/http/http_guard.h"
#include "server/http/origins.h"
#include "server/http/tls.h"
#include "server/measure/mesh_cache.h"
#include "server/measure/stores.h"
#include "server/observe/metrics.h"
#include "server/sandbox/memory_budget.h"
#include "server/sandbox/pool.h"
#include "server/settings/settings.h"
#include "server/store/forms/stores.h"

namespace meshgauge::server {

// Blocks signals in this thread and those it starts; sets up heap (server/base/heap.h), digests and the log; makes a
// file that grows beyond the limit on sizes an error, and no signal. Call before any thread starts. Throws
// std::system_error: the system grants no thread.
void set_up_process(const Settings& settings);

// Opens the stores of a process: embedded in data_dir, or on PostgreSQL and S3, as the settings say. Precondition:
// settings come from checked(). An Error names what cannot be opened.
Result<std::unique_ptr<store::AllStores>> open_stores(const Settings& settings);

// Returns the view of the stores that handlers and jobs use. Borrows everything; `maps` may be null.
Stores stores_of(store::AllStores& all, MeshCache& cache, MapCache* maps);

// `command`: the command line of the spawner of reader processes, a program that calls sandbox::run_spawner().
sandbox::PoolSettings pool_settings(const Settings& settings, const std::vector<std::string>& command);

// Returns the reason why the pool cannot read files now; empty: it can. Waits for a reader for a second at most.
std::string defect_of(sandbox::Pool& pool);

// Why no file can be created in the directory, which the text does not name; empty: one can.
std::string why_no_upload(const std::string& directory);
// The same as an Error, which names it.
Result<Done> check_temp_dir(const std::string& directory);

// Returns an Error if other machines can reach every address of the host, and neither keys_file nor public_without_keys
// is set. Binds nothing.
Result<Done> check_reach(const Settings& settings);

// Binds the guard and returns the port. An Error if the address is not available, or as check_reach() for the address
// that was bound.
Result<int> bind(HttpGuard& guard, const Settings& settings);

// The check of hosts and origins by settings from checked(). With keys it refuses nothing.
OriginCheck origin_check_of(const Settings& settings);

std::optional<Tls> tls_of(const Settings& settings);  // nullopt: the port speaks plain HTTP

// Reads the keys file, the certificate and its key. An Error: one of them cannot be used.
Result<Done> load_secrets(Access& access, std::optional<Tls>& tls);
// Reads them again and logs the result. A file that cannot be used leaves the old keys or certificate in force.
void reload_secrets(Access& access, std::optional<Tls>& tls);

void watch_memory(Metrics& metrics, const MemoryBudget& memory);
void watch_cache(Metrics& metrics, const MeshCache& cache, std::uint64_t max_bytes);  // borrows the cache

// The sums of all these guards, which it borrows.
void watch_handshakes(Metrics& metrics, const std::vector<const HttpGuard*>& guards);

// end: SIGTERM, SIGINT, or SIGHUP because the terminal was closed. reload: any other SIGHUP.
enum class Signal { none, end, reload };
Signal wait_for_signal(std::chrono::milliseconds time);  // blocks until a signal or the end of `time`, under a second

}  // namespace meshgauge::server
