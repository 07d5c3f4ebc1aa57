// The log: one line of JSON per event on stderr. Thread safe. It never holds contents of files; control characters are
// escaped, bytes that are not UTF-8 are replaced. No call waits for stderr (log_queue.h), and none but start_log()
// throws: lines that find no room are dropped and counted. The end of the process waits up to a second for lines that
// are not written.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/http/exchange.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

void start_log();  // starts the thread that writes, or throws std::system_error; without it the first line tries to
void log_request(const Exchange& exchange, double seconds);          // `seconds`: duration of the request
std::string request_line(const Exchange& exchange, double seconds);  // the line of log_request()
// Precondition: the job has ended. `triangles` of its meshes; nullopt: not known.
void log_job(const store::Job& row, const std::optional<MeshSizes>& triangles, const std::vector<api::Stage>& stages);
void log_listening(const std::string& address, const std::string& simd);  // `simd`: the instruction set in use
void log_event(const std::string& event, const std::string& detail);
std::uint64_t log_lines_dropped();  // since the start

}  // namespace meshgauge::server
