// Sends a response whose body is a mapped file, piece by piece.
#pragma once

#include "server/http/exchange.h"

namespace meshgauge::server {

// Sends the head and, unless the method is HEAD, the bytes of exchange.response.file. Stops with exchange.delivered
// false when the client disconnects, takes longer than 10 s for 1 MiB, or longer in all than 30 s and 1 s per 0.5 MB.
// `close`: the head says Connection: close. Takes no place of the client's address: the handler limits how many files
// are being sent. Blocks until sent or stopped.
void send_file(Exchange& exchange, bool close);

}  // namespace meshgauge::server
