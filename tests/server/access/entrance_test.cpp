#include "server/access/entrance.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include <doctest/doctest.h>

#include "server/access/keys.h"

using namespace meshgauge;
using server::Access;
using server::Cors;
using server::Entrance;
using server::Exchange;
using server::Head;
using server::Metrics;
using server::Scope;

namespace {

// A request that consists of a head.
struct Request {
  explicit Request(Head request_head)
      : head(std::move(request_head)), connection(-1), body(connection, head, 0), exchange("id", head, body) {}

  std::string header(const std::string& name) const {
    const auto& headers = exchange.response.headers;
    const auto found = std::find_if(headers.begin(), headers.end(), [&](const auto& h) { return h.first == name; });
    return found == headers.end() ? "" : found->second;
  }

  Head head;
  server::Connection connection;
  server::Body body;
  Exchange exchange;
};

Head head(const std::string& method, const std::string& path, const std::string& origin = "") {
  Head head;
  head.method = method;
  head.path = path;
  if (!origin.empty()) head.headers.emplace_back("origin", origin);
  return head;
}

Head preflight(const std::string& origin) {
  Head asked = head("OPTIONS", "/v1/comparisons", origin);
  asked.headers.emplace_back("access-control-request-method", "POST");
  return asked;
}

void pass(const Entrance& entrance, Request& request) {
  entrance(request.exchange, [](Exchange& exchange) {
    exchange.response.status = 222;
    return server::RequestHandler::Entry::answered;
  });
}

constexpr const char* kPage = "https://viewer.example";

}  // namespace

TEST_CASE("entrance: the paths that need no key, and what the others need") {
  for (const char* path :
       {"/", "/healthz", "/readyz", "/openapi.yaml", "/gates.schema.json", "/problems", "/problems/unauthorized",
        "/docs", "/docs/swagger-ui.css", "/b/0d67c9a2d1b307386f8fc157855c4351", "/c/0d67c9a2d1b307386f8fc157855c4351",
        "/b", "/c", "/page/main-7IQERKKA.js"}) {
    CHECK_MESSAGE(!server::scope_of_path(path), path);
  }
  CHECK(server::scope_of_path("/metrics") == Scope::metrics);
  for (const char* path :
       {"/v1/comparisons", "/v1/meshes/x", "/healthz/", "/docsx", "/metrics/", "//", "*", "/none", "/bc", "/page"}) {
    CHECK_MESSAGE(server::scope_of_path(path) == Scope::compare, path);
  }
}

TEST_CASE("entrance: with keys in force only the open paths are passed without one") {
  Access access("/some/file");  // which is not read, so no key is valid
  Metrics metrics;
  const Entrance entrance(access, metrics, Cors::parse("").value(), {});
  Request open(head("GET", "/healthz"));
  pass(entrance, open);
  CHECK(open.exchange.response.status == 222);
  for (const char* path : {"/v1/comparisons", "/metrics", "/none"}) {
    Request closed(head("GET", path));
    pass(entrance, closed);
    CHECK(closed.exchange.response.status == 401);
    CHECK(closed.header("WWW-Authenticate") == R"(Bearer realm="meshgauge")");
    CHECK(closed.exchange.problem == "/problems/unauthorized");
  }
}

TEST_CASE("entrance: failed authentications are counted by reason") {
  const std::string known(40, 'k');
  const auto file = std::filesystem::temp_directory_path() / ("entrance_test_keys." + std::to_string(::getpid()));
  std::ofstream(file) << R"({"keys": [{"id": "ci", "sha256": ")" << server::token_sha256(known) << "\"}]}";
  Access access(file.string());
  const auto loaded = access.reload();
  std::filesystem::remove(file);
  REQUIRE(loaded.ok());
  Metrics metrics;
  const Entrance entrance(access, metrics, Cors::parse("").value(), {});
  const auto status = [&](const char* path, const std::string& authorization) {
    Head asked = head("GET", path);
    if (!authorization.empty()) asked.headers.emplace_back("authorization", authorization);
    Request request(std::move(asked));
    pass(entrance, request);
    return request.exchange.response.status;
  };
  const auto counted = [&](const std::string& reason, int count) {
    const std::string line = "meshgauge_auth_failures_total{reason=\"" + reason + "\"} " + std::to_string(count) + "\n";
    return metrics.text().find(line) != std::string::npos;
  };
  CHECK(status("/v1/comparisons", "Bearer " + known) == 222);
  CHECK(status("/healthz", "Basic x") == 222);
  for (const char* reason : {"missing", "malformed", "unknown", "forbidden"}) CHECK_MESSAGE(counted(reason, 0), reason);
  CHECK(status("/v1/comparisons", "") == 401);
  CHECK(status("/v1/comparisons", "Basic " + known) == 401);
  CHECK(status("/v1/comparisons", "Bearer ") == 401);
  CHECK(status("/v1/comparisons", "Bearer " + known + "k") == 401);
  CHECK(status("/metrics", "Bearer " + known) == 403);
  CHECK(counted("missing", 1));
  CHECK(counted("malformed", 2));
  CHECK(counted("unknown", 1));
  CHECK(counted("forbidden", 1));
}

TEST_CASE("cors: off by default") {
  Access access("");
  Metrics metrics;
  const Entrance entrance(access, metrics, Cors::parse("").value(), {});
  Request request(head("GET", "/", kPage));
  pass(entrance, request);
  CHECK(request.exchange.response.headers.empty());
  Request asks(preflight(kPage));
  pass(entrance, asks);
  CHECK(asks.exchange.response.status == 222);
}

TEST_CASE("cors: only a listed origin may read") {
  Access access("/some/file");
  Metrics metrics;
  const Entrance entrance(access, metrics, Cors::parse("https://viewer.example, http://localhost:3000").value(), {});
  for (const char* origin : {kPage, "http://localhost:3000"}) {
    Request request(head("GET", "/healthz", origin));
    pass(entrance, request);
    CHECK(request.header("Access-Control-Allow-Origin") == origin);
    CHECK(request.header("Vary") == "Origin");
    const std::string shown = request.header("Access-Control-Expose-Headers");
    for (const char* name : {"Content-Disposition", "ETag", "Location", "Retry-After", "X-Request-Id"}) {
      CHECK_MESSAGE(shown.find(name) != std::string::npos, name);
    }
  }
  for (const char* origin : {"", "null", "*", "http://viewer.example", "https://viewer.example:443",
                             "https://viewer.example.evil", "https://Viewer.example"}) {
    Request request(head("GET", "/healthz", origin));
    pass(entrance, request);
    CHECK(request.header("Access-Control-Allow-Origin").empty());
    CHECK(request.header("Vary") == "Origin");
  }
  Request refused(head("GET", "/v1/comparisons", kPage));  // a page may read why
  pass(entrance, refused);
  CHECK(refused.exchange.response.status == 401);
  CHECK(refused.header("Access-Control-Allow-Origin") == kPage);
}

TEST_CASE("cors: a preflight needs no key, one of an unlisted origin is an ordinary request") {
  Access access("/some/file");
  Metrics metrics;
  const Entrance entrance(access, metrics, Cors::parse(kPage).value(), {});
  Request asks(preflight(kPage));
  pass(entrance, asks);
  CHECK(asks.exchange.response.status == 204);
  CHECK(asks.header("Access-Control-Allow-Origin") == kPage);
  for (const char* name : {"Authorization", "Idempotency-Key", "If-None-Match"}) {
    CHECK(asks.header("Access-Control-Allow-Headers").find(name) != std::string::npos);
  }
  CHECK(asks.header("Access-Control-Allow-Methods").find("DELETE") != std::string::npos);
  Request stranger(preflight("https://evil.example"));
  pass(entrance, stranger);
  CHECK(stranger.exchange.response.status == 401);
  Request plain(head("OPTIONS", "/v1/comparisons", kPage));
  pass(entrance, plain);
  CHECK(plain.exchange.response.status == 401);
}

TEST_CASE("cors: a text that is not an origin is refused") {
  for (const char* text : {"*", "viewer.example", "https://", "https://Viewer.example", "https://a.example/", "null",
                           "https://a.example https://b.example", "ftp://a.example"}) {
    CHECK_MESSAGE(!Cors::parse(text).ok(), text);
  }
  CHECK(Cors::parse("http://[::1]:8080").ok());
}

TEST_CASE("security headers: on every response, headers set by the handler stay") {
  server::Response response{200, "application/json", "{}", {}};
  add_security_headers(response);
  CHECK(response.headers == decltype(response.headers){{"X-Content-Type-Options", "nosniff"},
                                                       {"Cache-Control", "no-store"},
                                                       {"Referrer-Policy", "no-referrer"}});
  server::Response page{200, "text/html; charset=utf-8", "", {{"Cache-Control", "max-age=60"}}};
  add_security_headers(page);
  CHECK(page.headers.front().second == "max-age=60");
  CHECK(page.headers.size() == 4);
  CHECK(page.headers.back().first == "Content-Security-Policy");
}
