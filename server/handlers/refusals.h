// Problems that several handlers answer with.
#pragma once

#include <memory>
#include <string>

#include "api/base/problem.h"
#include "server/http/connection_limit.h"
#include "server/http/exchange.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

inline api::Problem shutting_down() {
  return {api::ProblemKind::shutting_down, "the service is shutting down and accepts no new work; retry later"};
}

// Serialized once: under overload most responses are this one.
inline const ProblemDocument& queue_full() {
  static const ProblemDocument document =
      document_of({api::ProblemKind::overloaded,
                   "all workers are busy, and the queue or this client's share of it is full; retry later"});
  return document;
}

// For clients that would occupy a connection for long: to follow events, download rows, or wait for a result.
inline api::Problem too_many_watchers(const Settings& settings) {
  return {api::ProblemKind::overloaded, "too many clients follow events or wait (limit " +
                                            std::to_string(settings.max_event_streams) + "); retry in a moment"};
}

// Takes a place for a response that streams. Null: there is none, and the exchange is answered.
std::shared_ptr<const void> take_place(Exchange& exchange, ConnectionLimit& watchers, const Settings& settings);

}  // namespace meshgauge::server
