// Sends chunked responses (RFC 9112 section 7.1) whose content is produced over time, and formats server-sent events
// (text/event-stream).
//
// The HTTP library's own streams are not used: they are cut off without an end when the library stops listening.
#pragma once

#include <string>
#include <string_view>

#include "server/http/exchange.h"

namespace meshgauge::server {

// Sends the head, then the pieces of exchange.response.stream until it returns false, then the terminating chunk. After
// 15 s without a piece it sends a comment, so that proxies keep the connection. Close the connection afterwards.
//
// Stops without a terminating chunk, exchange.delivered false, when the client disconnects, does not take a piece
// within 30 s, or the stream throws; so the client sees that the response is incomplete. Blocks until then.
void send_stream(Exchange& exchange);

// Returns one event as text. Precondition: `data` is one line.
std::string event(std::string_view name, std::string_view data);

}  // namespace meshgauge::server
