// What a server does with its requests: the HTTP server calls it, and the owner of the port implements it.
#pragma once

#include "server/http/exchange.h"

namespace meshgauge::server {

// Calls for one request come one after another: enter(), handle(), log(). For a request whose head is invalid or late,
// log() alone is called, with the refusal. Calls for different requests may come from several threads at once.
class RequestHandler {
 public:
  // Where a request is handled. answered: nowhere, enter() has set the response; status: on a thread for health checks
  // and metrics; handled: on a thread for all other requests.
  enum class Entry { answered, status, handled };

  virtual ~RequestHandler() = default;

  // Answers the request from its head alone, or names the threads for handle(). On the event loop's thread, so it must
  // not block. If it throws, the response is 500.
  virtual Entry enter(Exchange& exchange) = 0;

  // Sets the response, or what makes it later (Response::later, Response::stream). On a thread of a pool, so it may
  // call a store. If it throws, the response is 500. Not called if all threads are in use: the response is then 503.
  virtual void handle(Exchange& exchange) = 0;

  // Records the response when it has ended: after its last byte, or when it has broken off. On the event loop's thread
  // or on one of a pool, so it must not block. If it throws, the connection is closed.
  virtual void log(const Exchange& exchange) = 0;
};

}  // namespace meshgauge::server
