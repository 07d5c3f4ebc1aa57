#include "server/access/cors.h"

#include <algorithm>

#include "api/refused.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

constexpr const char* kMethods = "GET, HEAD, POST, PUT, DELETE";
constexpr const char* kRequestHeaders =
    "Authorization, Content-Disposition, Content-Type, Idempotency-Key, If-None-Match, Prefer, traceparent, tracestate";
constexpr const char* kResponseHeaders =
    "Content-Disposition, ETag, Location, Preference-Applied, Retry-After, Server-Timing, WWW-Authenticate, "
    "X-Request-Id";
constexpr const char* kMaxAgeSeconds = "600";

// scheme://host or scheme://host:port, in lower case, as in the WHATWG's serialization of an origin.
bool is_origin(std::string_view text) {
  std::string_view rest = text;
  const std::string_view scheme = next(rest, "://");
  if (scheme != "http" && scheme != "https") return false;
  return !rest.empty() && std::all_of(rest.begin(), rest.end(), [](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || std::string_view("-.:[]").find(c) != std::string_view::npos;
  });
}

}  // namespace

Result<Cors> Cors::parse(std::string_view origins) {
  Cors cors;
  while (!origins.empty()) {
    const std::string_view origin = trimmed(next(origins, ","));
    if (!is_origin(origin)) {
      return refused("--cors-origins: '" + std::string(origin) +
                     "' is not an origin; write each like https://viewer.example or http://localhost:3000, in lower "
                     "case");
    }
    cors.origins_.emplace_back(origin);
  }
  return cors;
}

bool Cors::allows(std::string_view origin) const {
  return std::find(origins_.begin(), origins_.end(), origin) != origins_.end();
}

void Cors::add_headers(Exchange& exchange) const {
  if (origins_.empty()) return;
  auto& headers = exchange.response.headers;
  add_vary(exchange.response, "Origin");
  const std::string_view origin = exchange.head.header("origin");
  if (!allows(origin)) return;
  headers.emplace_back("Access-Control-Allow-Origin", origin);
  headers.emplace_back("Access-Control-Expose-Headers", kResponseHeaders);
}

bool Cors::answer_preflight(Exchange& exchange) const {
  const bool is_preflight =
      exchange.head.method == "OPTIONS" && !exchange.head.header("access-control-request-method").empty();
  if (!is_preflight || !allows(exchange.head.header("origin"))) return false;
  exchange.response.status = kNoContent;
  add_headers(exchange);
  auto& headers = exchange.response.headers;
  headers.emplace_back("Access-Control-Allow-Methods", kMethods);
  headers.emplace_back("Access-Control-Allow-Headers", kRequestHeaders);
  headers.emplace_back("Access-Control-Max-Age", kMaxAgeSeconds);
  return true;
}

}  // namespace meshgauge::server
