// Everything an operator may set, with its default. Each field is a flag of `meshgauge serve`, an environment variable
// and a line of a file, of the same name: max_part_bytes is --max-part-bytes, MESHGAUGE_MAX_PART_BYTES and
// max_part_bytes.
#pragma once

#include <cstdint>
#include <string>

#include "api/formats/format.h"
#include "api/request.h"
#include "engine/result.h"

namespace meshgauge::server {

std::string default_temp_dir();  // TMPDIR or /tmp; whether it takes files is seen when the service starts

struct Settings {
  std::string host = "127.0.0.1";
  std::uint64_t port = 8080;
  std::string tls_certificate;
  std::string tls_key;
  std::string keys_file;
  bool public_without_keys = false;
  std::string cors_origins;
  std::uint64_t workers = 0;  // 0: one for each processor
  std::uint64_t queue = 16;
  std::uint64_t max_queued_jobs = 1000;
  std::uint64_t max_event_streams = 16;
  std::uint64_t io_threads = 0;  // 0: as many as the settings above ask for
  std::uint64_t max_pending_connections = 256;
  std::uint64_t max_arriving_per_peer = 0;  // 0: half of io_threads
  std::uint64_t default_timeout_ms = 30'000;
  std::uint64_t max_timeout_ms = 180'000;
  std::uint64_t head_timeout_ms = 10'000;
  std::uint64_t body_timeout_ms = 120'000;
  std::uint64_t keep_alive_ms = 15'000;
  std::uint64_t grace_ms = 10'000;
  std::uint64_t max_part_bytes = std::uint64_t{512} << 20;
  std::uint64_t max_request_bytes = std::uint64_t{1} << 30;
  std::uint64_t max_upload_bytes = std::uint64_t{4} << 30;
  std::uint64_t max_vertices = 50'000'000;
  std::uint64_t max_triangles = 50'000'000;
  std::uint64_t max_expanded_bytes = std::uint64_t{2} << 30;
  std::uint64_t max_heap_bytes = std::uint64_t{512} << 20;
  std::uint64_t max_cache_bytes = std::uint64_t{1} << 30;
  std::uint64_t parsers = 0;              // 0: as many as workers
  std::uint64_t parser_memory_bytes = 0;  // 0: what the limits on files allow
  std::string data_dir = ".meshgauge";
  std::uint64_t result_ttl_s = 86'400;
  std::uint64_t max_kept_results = 100'000;
  std::uint64_t mesh_ttl_s = 7 * 86'400;
  std::uint64_t max_stored_bytes = std::uint64_t{16} << 30;
  std::uint64_t map_cache_bytes = std::uint64_t{1} << 30;
  std::uint64_t map_cache_room_bytes = std::uint64_t{4} << 30;
  std::string temp_dir = default_temp_dir();
  std::string database;  // a secret, if it holds a password
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
  visit({"tls_certificate", "PEM file of a certificate and its chain: the port then speaks TLS alone"},
        s.tls_certificate);
  visit({"tls_key", "PEM file of the certificate's key, without a passphrase"}, s.tls_key);
  visit({"keys_file", "JSON file of bearer keys; empty: no request needs one"}, s.keys_file);
  visit({"public_without_keys", "Start without keys on an address that other machines can reach"},
        s.public_without_keys);
  visit({"cors_origins", "Origins of web pages that may read answers, separated by commas"}, s.cors_origins);
  visit({"workers", "Comparisons that run at the same time; 0: one for each processor"}, s.workers);
  visit({"queue", "Comparisons that may upload or wait beside those that run; beyond that: 503"}, s.queue);
  visit({"max_queued_jobs", "Comparisons that nobody waits for which may be queued or run; beyond that: 503"},
        s.max_queued_jobs);
  visit({"max_event_streams", "Clients that may watch a comparison, or wait for one as long as they prefer"},
        s.max_event_streams);
  visit({"io_threads", "Threads that serve connections; 0: as many as the settings above ask for"}, s.io_threads);
  visit({"max_pending_connections", "Connections that may wait for an I/O thread; beyond that: 503"},
        s.max_pending_connections);
  visit({"max_arriving_per_peer",
         "Requests of one client address that may still be arriving; beyond that: 429; 0: half of io_threads"},
        s.max_arriving_per_peer);
  visit({"default_timeout_ms", "Time of a comparison that names none"}, s.default_timeout_ms);
  visit({"max_timeout_ms", "Largest timeout_ms a request may ask for, at most 180000"}, s.max_timeout_ms);
  visit({"head_timeout_ms", "Time for a request's head to arrive in full"}, s.head_timeout_ms);
  visit({"body_timeout_ms", "Time for a request's body to arrive in full"}, s.body_timeout_ms);
  visit({"keep_alive_ms", "Time an idle connection is kept"}, s.keep_alive_ms);
  visit({"grace_ms", "Time that running requests have to finish after SIGTERM"}, s.grace_ms);
  visit({"max_part_bytes", "Largest mesh file"}, s.max_part_bytes);
  visit({"max_request_bytes", "Largest request body"}, s.max_request_bytes);
  visit({"max_upload_bytes", "Bytes of all uploads together, received or being measured"}, s.max_upload_bytes);
  visit({"max_vertices", "Largest mesh, in vertices"}, s.max_vertices);
  visit({"max_triangles", "Largest mesh, in triangles"}, s.max_triangles);
  visit({"max_expanded_bytes", "Largest gzip-compressed or 3MF mesh file, once expanded"}, s.max_expanded_bytes);
  visit({"max_heap_bytes", "Memory of one comparison's search, beside its meshes and trees"}, s.max_heap_bytes);
  visit({"max_cache_bytes", "Stored meshes kept in memory, with their trees, for the next comparison; 0: none"},
        s.max_cache_bytes);
  visit({"parsers", "Files read at the same time, each by a process of its own; 0: one for each worker"}, s.parsers);
  visit({"parser_memory_bytes", "Memory of such a process; 0: what the limits on files ask for"},
        s.parser_memory_bytes);
  visit({"data_dir", "Directory for what is kept: meshes, jobs and results; made when it is missing"}, s.data_dir);
  visit({"result_ttl_s", "Time a result is kept, in seconds"}, s.result_ttl_s);
  visit(
      {"max_kept_results", "Results that are kept; beyond that the oldest go, of the keys with more than their share"},
      s.max_kept_results);
  visit({"mesh_ttl_s", "Time a stored mesh is kept after its last use, in seconds"}, s.mesh_ttl_s);
  visit({"max_stored_bytes", "Meshes that one key may store, in bytes; all of them when there are no keys"},
        s.max_stored_bytes);
  visit({"map_cache_bytes", "Deviation maps kept as files in the data directory, in bytes; 0: none"},
        s.map_cache_bytes);
  visit({"map_cache_room_bytes", "Room that such maps leave on the disk, in bytes; on a small one a 64th of it"},
        s.map_cache_room_bytes);
  visit({"temp_dir", "Directory for uploads, as files without a name"}, s.temp_dir);
  visit({"database", "Connection string of the PostgreSQL that keeps jobs and results; empty: the data directory does"},
        s.database);
  visit({"blobs", "Where meshes are kept beside `database`: s3://BUCKET or s3://BUCKET/PREFIX; empty: in the database"},
        s.blobs);
  visit({"s3_endpoint", "URL of the S3 server; empty: Amazon's of the region"}, s.s3_endpoint);
  visit({"s3_region", "Region of the bucket"}, s.s3_region);
  visit({"s3_virtual_host", "The bucket is part of the server's name, not of the path"}, s.s3_virtual_host);
  visit({"blob_cache_bytes", "Files of meshes kept in the data directory beside `database`, in bytes"},
        s.blob_cache_bytes);
  visit({"lease_ms", "Time without a sign of life after which a worker's jobs go to others"}, s.lease_ms);
  visit({"heartbeat_ms", "Time between two signs of life of a worker, at most half of lease_ms"}, s.heartbeat_ms);
  visit({"max_batch_pairs", "Comparisons of one batch"}, s.max_batch_pairs);
  visit({"simd", "Instruction set: avx512, avx2, sse4, neon or scalar; auto: the fastest that the processor has"},
        s.simd);
  visit({"log_requests", "Which requests the log tells of: all, problems or none"}, s.log_requests);
}

// Of one request, and of one mesh file.
api::RequestLimits request_limits(const Settings& settings);
api::ReadLimits read_limits(const Settings& settings);

// Whether jobs, results and meshes are on engines that several machines share, or all in the data directory.
inline bool is_distributed(const Settings& settings) { return !settings.database.empty(); }

// How many files may be on their way to clients at a time: half of the threads that nothing else holds.
std::uint64_t most_files_sent(const Settings& settings);

// Fills in `workers`, `io_threads`, `max_arriving_per_peer`, `parsers`, `parser_memory_bytes` and `simd`, and refuses
// what this processor cannot run, and values that contradict each other.
Result<Settings> checked(Settings settings);

}  // namespace meshgauge::server
