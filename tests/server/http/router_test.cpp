#include "server/http/router.h"

#include <string>

#include <doctest/doctest.h>

#include "api/base/problem.h"

using namespace meshgauge::server;
using meshgauge::api::Problem;
using meshgauge::api::ProblemKind;

namespace {

// Returns the status of the router's answer; 0: the action of a route is to handle the request.
int refusal_by(const Router& router, const std::string& method, const std::string& path, const std::string& query) {
  Head head;
  head.method = method;
  head.path = path;
  head.query = query;
  Connection connection(-1);
  Body body(connection, head, 0);
  Exchange exchange("id", head, body);
  router(exchange);
  return exchange.action ? 0 : exchange.response.status;
}

}  // namespace

TEST_CASE("router: a query is refused where the route takes none") {
  Router router;
  router.add("GET", "/none", [](Exchange&) {});
  router.add("GET", "/some", [](Exchange&) {}).takes_query = true;
  CHECK(refusal_by(router, "GET", "/none", "") == 0);
  CHECK(refusal_by(router, "GET", "/none", "x=1") == 400);
  CHECK(refusal_by(router, "HEAD", "/none", "x=1") == 400);
  CHECK(refusal_by(router, "GET", "/some", "x=1") == 0);
  CHECK(refusal_by(router, "HEAD", "/some", "x=1") == 0);
}

TEST_CASE("router: path, method and the refusal of the route come before the query") {
  Router router;
  router.add("POST", "/full", [](Exchange&) {}).refuse = [](Exchange& exchange) {
    answer(exchange, Problem{ProblemKind::overloaded, "full", {}});
  };
  CHECK(refusal_by(router, "POST", "/nothing", "x=1") == 404);
  CHECK(refusal_by(router, "GET", "/full", "x=1") == 405);
  CHECK(refusal_by(router, "POST", "/full", "x=1") == 503);
}
