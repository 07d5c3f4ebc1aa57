// Maps method and path to a handler, by plain comparison: a regular expression on a hostile path can overflow the
// stack. In a template such as "/v1/comparisons/{}/events", {} matches exactly one segment that is not empty.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/http/exchange.h"

namespace meshgauge::server {

class Router {
 public:
  using Action = std::function<void(Exchange&)>;

  // `not_found`: detail of the 404 for a path without a route.
  explicit Router(std::string not_found = "no such path; /openapi.yaml describes all paths")
      : not_found_(std::move(not_found)) {}

  void add(std::string method, std::string path, Action action);

  // Sets exchange.route and exchange.segment and runs the action; answers 404 if no template matches the path, 405 with
  // Allow if only the method differs. HEAD runs the action of GET.
  void operator()(Exchange& exchange) const;

 private:
  struct Route {
    std::string method;
    std::string path;
    Action action;
  };
  const std::string not_found_;
  std::vector<Route> routes_;
};

}  // namespace meshgauge::server
