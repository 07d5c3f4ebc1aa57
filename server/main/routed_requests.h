// What a port of this program does with its requests: entrance, router, action of the route, record.
#pragma once

#include "server/access/entrance.h"
#include "server/http/request_handler.h"
#include "server/http/router.h"
#include "server/observe/metrics.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// Thread safe once the router has all its routes.
class RoutedRequests final : public RequestHandler {
 public:
  // Borrows all. Calls none of them before the first request.
  RoutedRequests(const Entrance& entrance, const Router& router, const Settings& settings, Metrics& metrics)
      : entrance_(entrance), router_(router), settings_(settings), metrics_(metrics) {}

  Entry enter(Exchange& exchange) override { return entrance_(exchange, router_); }
  void handle(Exchange& exchange) override { (*exchange.action)(exchange); }
  void log(const Exchange& exchange) override;  // counts the request and, depending on log_requests, logs it

 private:
  const Entrance& entrance_;
  const Router& router_;
  const Settings& settings_;
  Metrics& metrics_;
};

}  // namespace meshgauge::server
