// The log: one line of JSON an event, on stderr. Never a file's contents.
#pragma once

#include <string>

#include "server/exchange.h"

namespace meshgauge::server {

void log_request(const Exchange& exchange);
void log_listening(const std::string& address, const std::string& simd);  // the instruction set in use
void log_event(const std::string& event, const std::string& detail);

}  // namespace meshgauge::server
