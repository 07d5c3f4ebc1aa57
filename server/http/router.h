// Maps method and path to a handler, by plain comparison: a regular expression on a hostile path can overflow the
// stack. In a template such as "/v1/comparisons/{}/events", {} matches exactly one segment that is not empty.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/http/exchange.h"
#include "server/http/request_handler.h"

namespace meshgauge::server {

class Router {
 public:
  using Action = std::function<void(Exchange&)>;

  // `not_found`: detail of the 404 for a path without a route.
  explicit Router(std::string not_found = "no such path; /openapi.yaml describes all paths")
      : not_found_(std::move(not_found)) {}

  struct Route {
    std::string method;
    std::string path;
    Action action;             // of a request that has a thread: may call the store, but not wait for a client or job
    Action refuse = nullptr;   // answers a request that its head shows to be refused, or does nothing; must not block
    bool status = false;       // for probes and scrapes: not behind other requests
    bool takes_query = false;  // the action reads the query or ignores it; false: a request with one is refused
  };

  // Returns the new route, to set more of it before the next call.
  Route& add(std::string method, std::string path, Action action);

  // Sets exchange.route, segment and action, and runs `refuse` of the route; answers 404 if no template matches the
  // path, 405 with Allow if only the method differs, and last 400 to a query that the route does not take. HEAD has the
  // route of GET. Returns what handles the request.
  RequestHandler::Entry operator()(Exchange& exchange) const;

 private:
  const std::string not_found_;
  std::vector<Route> routes_;
};

}  // namespace meshgauge::server
