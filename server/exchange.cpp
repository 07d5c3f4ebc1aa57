#include "server/exchange.h"

namespace meshgauge::server {

void answer(Exchange& exchange, const api::Problem& problem) {
  Response& response = exchange.response;
  response.status = problem.status();
  response.content_type = "application/problem+json";
  response.body = to_json(problem);
  if (problem.status() == 503) response.headers.emplace_back("Retry-After", "1");
  exchange.problem = problem.type();
}

void note(Exchange& exchange, const api::Comparison& comparison) {
  const auto stages = api::stages(comparison);
  exchange.stages.assign(stages.begin(), stages.end());
  exchange.triangles = MeshSizes{comparison.a.triangles, comparison.b.triangles};
}

}  // namespace meshgauge::server
