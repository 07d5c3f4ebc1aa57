#include "server/router.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

void add_allowed(std::string& allowed, const std::string& method) {
  allowed += (allowed.empty() ? "" : ", ") + method + (method == "GET" ? ", HEAD" : "");
}

}  // namespace

void Router::add(std::string method, std::string path, Action action) {
  routes_.push_back({std::move(method), std::move(path), std::move(action)});
}

void Router::operator()(Exchange& exchange) const {
  const std::string wanted = exchange.head.method == "HEAD" ? "GET" : exchange.head.method;
  std::string allowed;
  for (const Route& route : routes_) {
    if (route.path != exchange.head.path) continue;
    exchange.route = route.path;
    if (route.method == wanted) return route.action(exchange);
    add_allowed(allowed, route.method);
  }
  if (allowed.empty()) return answer(exchange, Problem{ProblemKind::not_found, "there is nothing at this path", {}});
  exchange.response.headers.emplace_back("Allow", allowed);
  answer(exchange, Problem{ProblemKind::method_not_allowed, "this path takes " + allowed, {}});
}

}  // namespace meshgauge::server
