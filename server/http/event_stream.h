// A response that is sent piece by piece while it comes into being, chunked (RFC 9112 section 7.1), and the events
// that it is made of (text/event-stream).
//
// The HTTP library is not asked to: it breaks its streams off, without an end, when it stops listening.
#pragma once

#include <string>
#include <string_view>

#include "server/http/exchange.h"

namespace meshgauge::server {

// Sends head and pieces of exchange.response.stream, then ends the stream; the connection must end with it. It is not
// delivered when the client goes away, or takes no piece for 30 s, or the next piece throws: then the stream is broken
// off, and its reader knows that something is missing.
void send_stream(Exchange& exchange);

// One event. `data` is one line.
std::string event(std::string_view name, std::string_view data);

}  // namespace meshgauge::server
