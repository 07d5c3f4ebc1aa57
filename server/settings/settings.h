// The settings of the service, with their defaults, and how those of memory follow the machine. Each field is a flag of
// `meshgauge serve`, an environment variable and a line of a file: max_part_bytes is --max-part-bytes,
// MESHGAUGE_MAX_PART_BYTES and max_part_bytes.
#pragma once

#include <cstdint>
#include <string>

#include "api/formats/format.h"
#include "api/options/request.h"
#include "engine/result.h"

namespace meshgauge::server {

std::string default_temp_dir();  // TMPDIR or /tmp; check_temp_dir() checks it when the service starts

struct Settings {
  std::string host = "127.0.0.1";
  std::uint64_t port = 8080;
  std::uint64_t status_port = 0;  // 0: none
  std::string tls_certificate;
  std::string tls_key;
  std::string keys_file;
  bool public_without_keys = false;
  std::string cors_origins;
  std::string allowed_hosts;
  std::uint64_t workers = 0;  // 0: one per processor
  std::uint64_t queue = 16;
  std::uint64_t max_queued_jobs = 1000;
  std::uint64_t max_event_streams = 32;
  std::uint64_t io_threads = 64;
  std::uint64_t max_pending_connections = 256;
  std::uint64_t max_arriving_per_peer = 256;
  std::uint64_t max_handshakes_per_second = 400;
  std::uint64_t max_handshakes_per_second_per_peer = 20;
  std::uint64_t handshake_threads = 0;  // 0: one for every four processors
  std::uint64_t default_timeout_ms = 30'000;
  std::uint64_t max_timeout_ms = 180'000;
  std::uint64_t head_timeout_ms = 10'000;
  std::uint64_t body_timeout_ms = 120'000;
  std::uint64_t keep_alive_ms = 15'000;
  std::uint64_t grace_ms = 10'000;
  std::uint64_t max_part_bytes = std::uint64_t{512} << 20;
  std::uint64_t max_request_bytes = std::uint64_t{1} << 30;
  std::uint64_t max_upload_bytes = api::kUntrustedFileBytes;
  std::uint64_t max_vertices = api::kUntrustedLimits.max_vertices;
  std::uint64_t max_triangles = api::kUntrustedLimits.max_triangles;
  std::uint64_t max_expanded_bytes = api::kUntrustedLimits.max_expanded_bytes;
  std::uint64_t max_memory_bytes = 0;  // 0: what the machine can spare
  std::uint64_t max_heap_bytes = std::uint64_t{512} << 20;
  std::uint64_t max_cache_bytes = std::uint64_t{1} << 30;
  std::uint64_t parsers = 0;              // 0: one more than workers
  std::uint64_t parser_memory_bytes = 0;  // 0: derived from the limits on files and memory
  bool require_sandbox = false;
  std::string data_dir = ".meshgauge";
  std::uint64_t result_ttl_s = 86'400;
  std::uint64_t max_kept_results = 100'000;
  std::uint64_t mesh_ttl_s = 7 * 86'400;
  std::uint64_t max_stored_bytes = std::uint64_t{16} << 30;
  std::uint64_t max_stored_meshes = 100'000;
  std::uint64_t map_cache_bytes = std::uint64_t{1} << 30;
  std::uint64_t map_cache_room_bytes = std::uint64_t{4} << 30;
  std::string temp_dir = default_temp_dir();
  std::string database;  // may hold a password
  std::string blobs;
  std::string s3_endpoint;
  std::string s3_region = "us-east-1";
  bool s3_virtual_host = false;
  std::uint64_t blob_cache_bytes = std::uint64_t{10} << 30;
  std::uint64_t lease_ms = 75'000;
  std::uint64_t heartbeat_ms = 10'000;
  std::uint64_t max_batch_pairs = 10'000;
  std::string simd = "auto";
  std::string log_requests = "all";
};

struct SettingText {
  const char* name;  // with underscores
  const char* help;
};

// Calls visit(SettingText, field) for every setting, in the order of the documentation. `s`: Settings, const or not.
template <class SomeSettings, class Visit>
void for_each_setting(SomeSettings& s, Visit visit) {
  visit({"host", "Address to listen on"}, s.host);
  visit({"port", "Port to listen on; 0 takes a free one"}, s.port);
  visit({"status_port", "A second port, for /healthz, /readyz and /metrics alone; 0: none"}, s.status_port);
  visit({"tls_certificate", "PEM file of the certificate and its chain; with it the port serves TLS only"},
        s.tls_certificate);
  visit({"tls_key", "PEM file of the certificate's key, without a passphrase"}, s.tls_key);
  visit({"keys_file", "JSON file of bearer keys; empty: requests need no key"}, s.keys_file);
  visit({"public_without_keys", "Allow serving without keys on an address that other machines can reach"},
        s.public_without_keys);
  visit({"cors_origins", "Origins whose web pages may read responses, separated by commas"}, s.cors_origins);
  visit({"allowed_hosts",
         "Host names that requests without keys may be sent to, beside localhost and addresses, separated by commas"},
        s.allowed_hosts);
  visit({"workers", "Maximum number of comparisons running at the same time; 0: one per processor"}, s.workers);
  visit({"queue",
         "Maximum number of comparisons of one client uploading or waiting beside the running ones, and of all clients "
         "a quarter of workers and queue more; beyond it: 503"},
        s.queue);
  visit({"max_queued_jobs",
         "Maximum number of durable comparisons queued or running, batches apart, and without a database a quarter "
         "more while several clients have some; beyond it: 503"},
        s.max_queued_jobs);
  visit({"max_event_streams",
         "Maximum number of connections following events or waiting with Prefer: wait, half of them of one client "
         "(key, or address without keys); beyond it: 503, and the state of a batch at once"},
        s.max_event_streams);
  visit({"io_threads", "Threads that handle requests; a request that is waited for, or that waits, takes none"},
        s.io_threads);
  visit({"max_pending_connections", "Maximum number of requests waiting for an I/O thread; beyond it: 503"},
        s.max_pending_connections);
  visit({"max_arriving_per_peer", "Maximum number of requests still arriving from one client address; beyond it: 429"},
        s.max_arriving_per_peer);
  visit({"max_handshakes_per_second",
         "Maximum number of TLS handshakes a second; more wait, and where 256 wait, those of the busiest client "
         "addresses are refused"},
        s.max_handshakes_per_second);
  visit({"max_handshakes_per_second_per_peer",
         "Maximum number of TLS handshakes a second from one client address, and five times as many at once after a "
         "pause; beyond it: refused. Where one address stands for many clients, as a load balancer's does, set it to "
         "max_handshakes_per_second"},
        s.max_handshakes_per_second_per_peer);
  visit({"handshake_threads", "Threads for the costly step of TLS handshakes; 0: one for every four processors"},
        s.handshake_threads);
  visit({"default_timeout_ms", "Time limit of a comparison without timeout_ms"}, s.default_timeout_ms);
  visit({"max_timeout_ms", "Maximum timeout_ms of a comparison, up to 180000"}, s.max_timeout_ms);
  visit({"head_timeout_ms", "Maximum time for a request's head to arrive"}, s.head_timeout_ms);
  visit({"body_timeout_ms", "Maximum time for a request's body to arrive"}, s.body_timeout_ms);
  visit({"keep_alive_ms", "Time that an idle connection is kept open"}, s.keep_alive_ms);
  visit({"grace_ms", "Time that running requests have to finish after SIGTERM"}, s.grace_ms);
  visit({"max_part_bytes", "Maximum size of a mesh file"}, s.max_part_bytes);
  visit({"max_request_bytes", "Maximum size of a request body"}, s.max_request_bytes);
  visit({"max_upload_bytes",
         "Maximum size of all uploads together that are being received or measured; with temp_dir on a tmpfs at most a "
         "quarter of the machine's memory"},
        s.max_upload_bytes);
  visit({"max_vertices", "Maximum number of vertices of a mesh"}, s.max_vertices);
  visit({"max_triangles", "Maximum number of triangles of a mesh"}, s.max_triangles);
  visit({"max_expanded_bytes", "Maximum size of a gzip-compressed or 3MF file after decompression"},
        s.max_expanded_bytes);
  visit({"max_memory_bytes",
         "Maximum memory of all comparisons and reader processes together; 0: what the machine can spare"},
        s.max_memory_bytes);
  visit({"max_heap_bytes",
         "Maximum memory of one comparison's search, without its meshes and trees; all searches together get a quarter "
         "of max_memory_bytes"},
        s.max_heap_bytes);
  visit(
      {"max_cache_bytes",
       "Maximum memory of cached stored meshes with their trees, and at most an eighth of the machine's; 0: no cache"},
      s.max_cache_bytes);
  visit({"parsers", "Maximum number of reader processes, each reading one file; 0: one more than workers"}, s.parsers);
  visit({"parser_memory_bytes",
         "Maximum memory of a reader process; 0: derived from the limits on files, at most half of max_memory_bytes"},
        s.parser_memory_bytes);
  visit({"require_sandbox", "End the start where the kernel lacks a protection of the processes that read uploads"},
        s.require_sandbox);
  visit({"data_dir", "Directory of stored meshes, jobs and results; created if missing"}, s.data_dir);
  visit({"result_ttl_s",
         "Seconds that a result is kept, and that a durable comparison outside of a batch may wait to be run"},
        s.result_ttl_s);
  visit({"max_kept_results", "Maximum number of results kept; beyond it the oldest of keys above their share go"},
        s.max_kept_results);
  visit({"mesh_ttl_s", "Seconds that a stored mesh is kept after its last use"}, s.mesh_ttl_s);
  visit({"max_stored_bytes", "Maximum size of all meshes stored by one key; without keys: of all meshes"},
        s.max_stored_bytes);
  visit({"max_stored_meshes", "Maximum number of meshes stored by one key; without keys: of all meshes"},
        s.max_stored_meshes);
  visit({"map_cache_bytes", "Maximum size of deviation maps cached as files in data_dir; 0: no cache"},
        s.map_cache_bytes);
  visit({"map_cache_room_bytes", "Free disk space that the cached maps leave, at most a 64th of the disk"},
        s.map_cache_room_bytes);
  visit({"temp_dir", "Directory for uploads, which are unnamed files"}, s.temp_dir);
  visit({"database", "PostgreSQL connection string of the store of jobs and results; empty: they are in data_dir"},
        s.database);
  visit({"blobs", "Store of meshes beside `database`: s3://BUCKET or s3://BUCKET/PREFIX; empty: in the database"},
        s.blobs);
  visit({"s3_endpoint", "URL of the S3 server; empty: Amazon's server of the region"}, s.s3_endpoint);
  visit({"s3_region", "Region of the bucket"}, s.s3_region);
  visit({"s3_virtual_host", "Address the bucket by the server's name, not by the path"}, s.s3_virtual_host);
  visit({"blob_cache_bytes", "Maximum size of mesh files cached in data_dir beside `database`"}, s.blob_cache_bytes);
  visit({"lease_ms", "Time without a heartbeat after which a worker's jobs are requeued"}, s.lease_ms);
  visit({"heartbeat_ms", "Time between two heartbeats of a worker, at most half of lease_ms"}, s.heartbeat_ms);
  visit({"max_batch_pairs", "Maximum number of comparisons of one batch"}, s.max_batch_pairs);
  visit({"simd", "Instruction set: avx512, avx2, sse4, neon or scalar; auto: the fastest that the processor has"},
        s.simd);
  visit({"log_requests", "Which requests are logged: all, problems or none"}, s.log_requests);
}

// Worker threads beside `workers`, for clients that have no comparison running (scheduler.h).
inline constexpr std::uint64_t kGuests = 1;

api::RequestLimits request_limits(const Settings& settings);  // limits of one request's options
api::ReadLimits read_limits(const Settings& settings);        // limits of one mesh file

// True: jobs, results and meshes are in a database that several processes share. False: they are in data_dir.
inline bool is_distributed(const Settings& settings) { return !settings.database.empty(); }

// Maximum number of files sent to clients at the same time: half of the I/O threads.
// Precondition: settings come from checked().
std::uint64_t max_files_sent(const Settings& settings);

struct MachineMemory {
  std::uint64_t bytes = 0;           // that this process and its readers may use
  bool uploads_take_memory = false;  // temp_dir is on a tmpfs
};

MachineMemory machine_memory(const std::string& temp_dir);

// Fills in `max_memory_bytes` and `parser_memory_bytes` in place of 0, and lowers `max_cache_bytes`, `max_upload_bytes`
// and `max_heap_bytes` to what the machine can spare. Precondition: `workers` is not 0.
void plan_memory(const MachineMemory& machine, Settings& settings);

// What `max_memory_bytes` leave for meshes and readers when each thread that measures has its `max_heap_bytes`.
std::uint64_t memory_for_meshes(const Settings& settings);

// For the log: what the machine has, and how it is divided.
std::string memory_text(const Settings& settings);

}  // namespace meshgauge::server
