// What all connections of one server share.
#pragma once

#include <chrono>
#include <memory>

#include "server/http/connection_limit.h"
#include "server/http/handshakes.h"
#include "server/http/io_pool.h"
#include "server/http/request_handler.h"
#include "server/http/tls.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

struct Edge {
  const Settings settings;
  const std::chrono::milliseconds write_time;  // for a response, or a piece of a stream
  const Tls* tls;                              // null: plain HTTP
  RequestHandler& handler;
  ConnectionLimit peers;  // connections whose bytes are due
  IoPool requests;
  IoPool status;                                 // for health checks and metrics: not behind other requests
  const std::unique_ptr<Handshakes> handshakes;  // null: plain HTTP
};

}  // namespace meshgauge::server
