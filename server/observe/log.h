// The log: one line of JSON an event, on stderr, written at once and in one piece. Never a file's contents; control
// characters are escaped and what is not UTF-8 is replaced.
#pragma once

#include <string>

#include "server/http/exchange.h"

namespace meshgauge::server {

struct JobView;

void log_request(const Exchange& exchange, double seconds);
std::string request_line(const Exchange& exchange, double seconds);       // what log_request() writes, newline included
void log_job(const JobView& job);                                         // that has ended
std::string job_line(const JobView& job);                                 // what log_job() writes, newline included
void log_listening(const std::string& address, const std::string& simd);  // the instruction set in use
void log_event(const std::string& event, const std::string& detail);

}  // namespace meshgauge::server
