// Everything an operator may set, with its default. Each field is a flag of `meshgauge serve` and an
// environment variable of the same name: max_part_bytes is --max-part-bytes and MESHGAUGE_MAX_PART_BYTES.
#pragma once

#include <cstdint>
#include <string>

#include "engine/result.h"

namespace meshgauge::server {

std::string default_temp_dir();  // TMPDIR or /tmp; whether it takes files is seen when the service starts

struct Settings {
  std::string host = "127.0.0.1";
  std::uint64_t port = 8080;
  std::uint64_t workers = 0;  // 0: one for each processor
  std::uint64_t queue = 32;
  std::uint64_t io_threads = 64;
  std::uint64_t max_pending_connections = 256;
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
  std::string temp_dir = default_temp_dir();
  std::string simd = "auto";
};

struct SettingText {
  const char* name;  // with underscores
  const char* help;
};

// Calls visit(SettingText, field) for every setting, in the order of the documentation.
template <class Visit>
void for_each_setting(Settings& s, Visit visit) {
  visit({"host", "Address to listen on"}, s.host);
  visit({"port", "Port to listen on; 0 takes a free one"}, s.port);
  visit({"workers", "Comparisons that run at the same time; 0: one for each processor"}, s.workers);
  visit({"queue", "Comparisons that may upload or wait beside those that run; beyond that: 503"}, s.queue);
  visit({"io_threads", "Threads that serve connections; at least workers + queue + 2"}, s.io_threads);
  visit({"max_pending_connections", "Connections that may wait for an I/O thread; beyond that: 503"},
        s.max_pending_connections);
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
  visit({"temp_dir", "Directory for uploads, as files without a name"}, s.temp_dir);
  visit({"simd", "Instruction set: avx512, avx2, sse4, neon or scalar; auto: the fastest that the processor has"},
        s.simd);
}

// Fills in `workers`, `parsers`, `parser_memory_bytes` and `simd`, and refuses what this processor cannot run, and
// values that contradict each other.
Result<Settings> checked(Settings settings);

}  // namespace meshgauge::server
