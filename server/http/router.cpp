#include "server/http/router.h"

#include <optional>
#include <string_view>

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

void add_allowed(std::string& allowed, const std::string& method) {
  allowed += (allowed.empty() ? "" : ", ") + method + (method == "GET" ? ", HEAD" : "");
}

// Returns the segment that {} matches, empty if the pattern has none. nullopt: the path does not match.
std::optional<std::string> match(std::string_view pattern, std::string_view path) {
  const std::size_t hole = pattern.find("{}");
  if (hole == std::string_view::npos) return path == pattern ? std::optional(std::string()) : std::nullopt;
  const std::string_view before = pattern.substr(0, hole);
  const std::string_view after = pattern.substr(hole + 2);
  if (path.size() <= before.size() + after.size() || !path.starts_with(before) || !path.ends_with(after)) {
    return std::nullopt;
  }
  const std::string_view segment = path.substr(hole, path.size() - before.size() - after.size());
  if (segment.find('/') != std::string_view::npos) return std::nullopt;
  return std::string(segment);
}

// A misplaced option must not be ignored silently.
void refuse_query(Exchange& exchange) {
  if (!exchange.head.query.empty()) answer(exchange, malformed("this path takes no query parameters"));
}

}  // namespace

Router::Route& Router::add(std::string method, std::string path, Action action) {
  return routes_.emplace_back(Route{std::move(method), std::move(path), std::move(action)});
}

RequestHandler::Entry Router::operator()(Exchange& exchange) const {
  const std::string wanted = exchange.head.method == "HEAD" ? "GET" : exchange.head.method;
  std::string allowed;
  for (const Route& route : routes_) {
    auto segment = match(route.path, exchange.head.path);
    if (!segment) continue;
    exchange.route = route.path;
    exchange.segment = std::move(*segment);
    if (route.method != wanted) {
      add_allowed(allowed, route.method);
      continue;
    }
    if (route.refuse) route.refuse(exchange);
    if (!route.takes_query && exchange.problem.empty()) refuse_query(exchange);
    if (!exchange.problem.empty()) return RequestHandler::Entry::answered;
    exchange.action = &route.action;
    return route.status ? RequestHandler::Entry::status : RequestHandler::Entry::handled;
  }
  if (allowed.empty()) {
    answer(exchange, Problem{ProblemKind::not_found, not_found_});
  } else {
    exchange.response.headers.emplace_back("Allow", allowed);
    answer(exchange,
           Problem{ProblemKind::method_not_allowed, "this path does not support the method; it takes " + allowed});
  }
  return RequestHandler::Entry::answered;
}

}  // namespace meshgauge::server
