#include "server/http/origins.h"

#include <algorithm>

#include "api/base/refused.h"
#include "api/formats/file/source.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

constexpr const char* kMethods = "GET, HEAD, POST, PUT, DELETE";
constexpr const char* kRequestHeaders =
    "Authorization, Content-Disposition, Content-Type, Idempotency-Key, If-None-Match, Prefer, traceparent, tracestate";
constexpr const char* kResponseHeaders =
    "Content-Disposition, ETag, Location, Preference-Applied, Retry-After, Server-Timing, WWW-Authenticate, "
    "X-Request-Id";
constexpr const char* kMaxAgeSeconds = "600";
constexpr std::size_t kShown = 100;  // bytes of a header in a message

// scheme://host or scheme://host:port, in lower case, as in the WHATWG's serialization of an origin.
bool is_origin(std::string_view text) {
  std::string_view rest = text;
  const std::string_view scheme = next(rest, "://");
  if (scheme != "http" && scheme != "https") return false;
  return !rest.empty() && std::all_of(rest.begin(), rest.end(), [](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || std::string_view("-.:[]").find(c) != std::string_view::npos;
  });
}

std::string in_message(std::string_view text) { return "'" + api::printable(text, kShown) + "'"; }

bool is_host(std::string_view text) {
  const bool is_address = text.starts_with('[') && text.ends_with(']');
  const std::string_view allowed = is_address ? "[:]" : "-.";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || allowed.find(c) != std::string_view::npos;
  });
}

// The "host:port" of an origin. Empty: it has none, as "null", which browsers send for files and sandboxed frames.
std::string_view authority_of(std::string_view origin) {
  const std::size_t scheme = origin.find("://");
  return scheme == std::string_view::npos ? std::string_view() : origin.substr(scheme + 3);
}

bool changes_something(const std::string& method) { return method != "GET" && method != "HEAD" && method != "OPTIONS"; }

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

Result<OriginCheck> OriginCheck::parse(std::string_view allowed_hosts, Hosts hosts, Cors cors) {
  OriginCheck check;
  check.active_ = true;
  check.cors_ = std::move(cors);
  while (!allowed_hosts.empty()) {
    const std::string_view host = trimmed(next(allowed_hosts, ","));
    if (!is_host(host)) {
      return refused("--allowed-hosts: '" + std::string(host) +
                     "' is not a host name; write each like gauge.example, in lower case, without scheme and port");
    }
    check.hosts_.emplace_back(host);
  }
  check.any_host_ = hosts == Hosts::any && check.hosts_.empty();
  return check;
}

// An address cannot be made to resolve elsewhere: a browser that names it has connected to it.
bool OriginCheck::is_own(const Authority& authority) const {
  return authority.kind != Authority::Kind::name || authority.host == "localhost" ||
         std::find(hosts_.begin(), hosts_.end(), authority.host) != hosts_.end();
}

std::optional<Problem> OriginCheck::find_refusal(const Head& head) const {
  if (!active_) return std::nullopt;
  const std::string authority = lower(head.header("host"));
  const auto parsed = parse_authority(authority);
  if (!any_host_ && !authority.empty() && !(parsed && is_own(*parsed))) {
    return Problem{ProblemKind::foreign_request,
                   "the Host " + in_message(authority) +
                       " is not a name of this service; use localhost, or add the name to --allowed-hosts"};
  }
  const std::string_view origin = head.header("origin");
  if (origin.empty() || !changes_something(head.method) || cors_.allows(origin)) return std::nullopt;
  if (!authority.empty() && lower(authority_of(origin)) == authority) return std::nullopt;
  return Problem{ProblemKind::foreign_request,
                 "the request comes from a page of " + in_message(origin) +
                     ", not of this service; add that origin to --cors-origins to allow it"};
}

}  // namespace meshgauge::server
