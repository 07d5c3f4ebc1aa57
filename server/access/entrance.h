// The checks of every request before routing, on its head alone: CORS preflight, host and origin,
// key, rate and scope.
#pragma once

#include <optional>
#include <string_view>

#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/http/origins.h"
#include "server/http/request_handler.h"
#include "server/observe/metrics.h"

namespace meshgauge::server {

class Entrance {
 public:
  Entrance(Access& access, Metrics& metrics, Cors cors, OriginCheck origins)
      : access_(access), metrics_(metrics), cors_(std::move(cors)), origins_(std::move(origins)) {}

  // Answers a preflight or a denied request; else sets exchange.owner and returns what `route` says. Adds CORS headers
  // to the response of either. Does not block.
  template <class Route>
  RequestHandler::Entry operator()(Exchange& exchange, const Route& route) const {
    if (cors_.answer_preflight(exchange)) return RequestHandler::Entry::answered;
    const auto entry = admit(exchange) ? route(exchange) : RequestHandler::Entry::answered;
    cors_.add_headers(exchange);
    return entry;
  }

 private:
  bool admit(Exchange& exchange) const;

  Access& access_;
  Metrics& metrics_;  // counts failed authentications
  const Cors cors_;
  const OriginCheck origins_;
};

// Returns the scope that a path requires; nullopt: it needs no key. Unknown paths require Scope::compare.
std::optional<Scope> scope_of_path(std::string_view path);

// Sets the response to the denial's problem and headers.
void answer(Exchange& exchange, const Denial& denial);

}  // namespace meshgauge::server
