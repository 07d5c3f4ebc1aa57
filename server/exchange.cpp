#include "server/exchange.h"

namespace meshgauge::server {

void answer(Exchange& exchange, const api::Problem& problem) {
  Response& response = exchange.response;
  response.status = problem.status();
  response.content_type = "application/problem+json";
  response.body = to_json(problem);
  if (problem.status() == 503 || problem.status() == 429) response.headers.emplace_back("Retry-After", "1");
  exchange.problem = problem.type();
}

}  // namespace meshgauge::server
