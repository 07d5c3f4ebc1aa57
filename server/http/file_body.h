// A response whose body is a file: sent from its mapping, piece by piece, so that it is never in memory as a whole.
#pragma once

#include "server/http/exchange.h"

namespace meshgauge::server {

// Sends the head and exchange.response.file, of which HEAD gets the length alone. Not delivered when the client goes
// away, takes less than half a megabyte a second for long, or less than one in ten seconds. Takes no place of its
// address: whoever offers files bounds how many are on their way. `close`: the connection ends with it, and the head
// says so.
void send_file(Exchange& exchange, bool close);

}  // namespace meshgauge::server
