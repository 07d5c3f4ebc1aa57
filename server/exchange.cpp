#include "server/exchange.h"

#include <algorithm>

namespace meshgauge::server {

void answer(Exchange& exchange, const api::Problem& problem) { answer(exchange, problem, std::chrono::seconds(1)); }

void answer(Exchange& exchange, const api::Problem& problem, std::chrono::milliseconds retry_after) {
  Response& response = exchange.response;
  response.status = problem.status();
  response.content_type = "application/problem+json";
  response.body = to_json(problem);
  if (problem.status() == 503 || problem.status() == 429) {
    const auto seconds = std::clamp<std::int64_t>(std::chrono::ceil<std::chrono::seconds>(retry_after).count(), 1, 60);
    response.headers.emplace_back("Retry-After", std::to_string(seconds));
  }
  exchange.problem = problem.type();
}

std::optional<api::Problem> refuse_query(const Exchange& exchange) {
  if (exchange.head.query.empty()) return std::nullopt;
  return api::Problem{api::ProblemKind::malformed_request, "this path takes no query parameters", {}};
}

}  // namespace meshgauge::server
