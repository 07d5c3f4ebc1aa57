// What all connections of one server share.
#pragma once

#include <functional>

#include "server/http/connection_limit.h"
#include "server/http/exchange.h"
#include "server/http/io_pool.h"
#include "server/http/tls.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

struct Edge {
  // Where a request with a valid head is handled: it is answered already; or by a thread for status requests, or for
  // all others.
  enum class Entry { answered, status, handled };

  const Settings settings;
  const Tls* tls;  // null: plain HTTP
  // On the event loop's thread, so it must not block: answers from the head alone, or names the threads for handle().
  std::function<Entry(Exchange&)> enter;
  std::function<void(Exchange&)> handle;
  std::function<void(const Exchange&)> log;  // after the last byte of each response
  std::function<bool()> stopping;            // connections end after their response
  ConnectionLimit peers;                     // connections whose bytes are due
  IoPool requests;
  IoPool status;  // for health checks and metrics: not behind other requests
};

}  // namespace meshgauge::server
