// What every request passes before it is routed, on its head alone: browsers' questions, keys, scopes and rates.
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

  // Runs `go_on` with exchange.owner set, or answers; what either answers is marked for the pages that may read it.
  template <class GoOn>
  void operator()(Exchange& exchange, const GoOn& go_on) const {
    if (cors_.answer_preflight(exchange)) return;
    if (admit(exchange)) go_on(exchange);
    cors_.add_headers(exchange);
  }

 private:
  bool admit(Exchange& exchange) const;

  Access& access_;
  Metrics& metrics_;  // told of keys that did not fit
  const Cors cors_;
};

// What a path needs of a key; nullopt: it is open to everybody.
std::optional<Scope> scope_of_path(std::string_view path);

// Makes the answer of this exchange a denial.
void answer(Exchange& exchange, const Denial& denial);

}  // namespace meshgauge::server
