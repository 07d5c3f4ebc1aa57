#include "server/http/exchange.h"

#include <algorithm>

namespace meshgauge::server {
namespace {

void add_missing(Response& response, const char* name, const char* value) {
  const bool there = std::any_of(response.headers.begin(), response.headers.end(),
                                 [&](const auto& header) { return header.first == name; });
  if (!there) response.headers.emplace_back(name, value);
}

}  // namespace

void answer(Exchange& exchange, const api::Problem& problem) { answer(exchange, problem, std::chrono::seconds(1)); }

void answer(Exchange& exchange, const api::Problem& problem, std::chrono::milliseconds retry_after) {
  answer(exchange, document_of(problem), retry_after);
}

ProblemDocument document_of(const api::Problem& problem) {
  return {problem.status(), problem.type(), to_json(problem)};
}

void answer(Exchange& exchange, ProblemDocument document, std::chrono::milliseconds retry_after) {
  Response& response = exchange.response;
  response.later = nullptr;
  response.stream = nullptr;
  response.file.reset();
  response.length_known = true;
  response.status = document.status;
  response.content_type = "application/problem+json";
  response.body = std::move(document.json);
  if (may_retry(document.status)) {
    const auto seconds = std::clamp<std::int64_t>(std::chrono::ceil<std::chrono::seconds>(retry_after).count(), 1, 60);
    response.headers.emplace_back("Retry-After", std::to_string(seconds));
  }
  exchange.problem = std::move(document.type);
}

std::optional<api::Problem> refuse_query(const Exchange& exchange) {
  if (exchange.head.query.empty()) return std::nullopt;
  return malformed("this path takes no query parameters");
}

void add_vary(Response& response, const std::string& header) {
  for (auto& [name, value] : response.headers) {
    if (name != "Vary") continue;
    value += ", " + header;
    return;
  }
  response.headers.emplace_back("Vary", header);
}

void add_security_headers(Response& response) {
  add_missing(response, "X-Content-Type-Options", "nosniff");
  add_missing(response, "Cache-Control", "no-store");
  add_missing(response, "Referrer-Policy", "no-referrer");
  if (!response.content_type.starts_with("text/html")) return;
  add_missing(response, "Content-Security-Policy",
              "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
}

}  // namespace meshgauge::server
