// A response that is sent piece by piece while it comes into being, chunked (RFC 9112 section 7.1), and the events
// that it is made of (text/event-stream).
//
// The HTTP library is not asked to: it breaks its streams off, without an end, when it stops listening.
#pragma once

#include <string>
#include <string_view>

#include "server/connection.h"
#include "server/exchange.h"

namespace meshgauge::server {

// Sends head and pieces of response.stream, then closes the stream; the connection must end with it. False: the client
// went away, or took no piece for 30 s.
bool send_stream(Connection& connection, const Response& response);

// One event. `data` is one line.
std::string event(std::string_view name, std::string_view data);

}  // namespace meshgauge::server
