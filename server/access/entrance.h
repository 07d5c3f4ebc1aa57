// The checks of every request before routing, on its head alone: CORS preflight, key, rate and scope.
#pragma once

#include <optional>
#include <string_view>

#include "server/access/access.h"
#include "server/access/cors.h"
#include "server/http/exchange.h"
#include "server/observe/metrics.h"

namespace meshgauge::server {

class Entrance {
 public:
  Entrance(Access& access, Metrics& metrics, Cors cors) : access_(access), metrics_(metrics), cors_(std::move(cors)) {}

  // Answers a preflight or a denied request; else sets exchange.owner and calls `go_on`. Adds CORS headers to the
  // response of either.
  template <class GoOn>
  void operator()(Exchange& exchange, const GoOn& go_on) const {
    if (cors_.answer_preflight(exchange)) return;
    if (admit(exchange)) go_on(exchange);
    cors_.add_headers(exchange);
  }

 private:
  bool admit(Exchange& exchange) const;

  Access& access_;
  Metrics& metrics_;  // counts failed authentications
  const Cors cors_;
};

// Returns the scope that a path requires; nullopt: it needs no key. Unknown paths require Scope::compare.
std::optional<Scope> scope_of_path(std::string_view path);

// Sets the response to the denial's problem and headers.
void answer(Exchange& exchange, const Denial& denial);

}  // namespace meshgauge::server
