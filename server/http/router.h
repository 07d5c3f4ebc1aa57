// Method and path to handler, by plain comparison: a regular expression on a hostile path can overflow the stack.
// "/v1/comparisons/{}/events" takes any one segment, not empty, for its {}.
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

  // `nothing`: what a 404 says.
  explicit Router(std::string nothing = "there is nothing at this path") : nothing_(std::move(nothing)) {}

  void add(std::string method, std::string path, Action action);

  // Runs the action, with what stood for the {} in exchange.segment, or answers 404, or 405 with Allow. HEAD goes where
  // GET goes.
  void operator()(Exchange& exchange) const;

 private:
  struct Route {
    std::string method;
    std::string path;
    Action action;
  };
  const std::string nothing_;
  std::vector<Route> routes_;
};

}  // namespace meshgauge::server
