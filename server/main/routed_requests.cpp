#include "server/main/routed_requests.h"

#include <chrono>

#include "server/observe/log.h"

namespace meshgauge::server {

void RoutedRequests::log(const Exchange& exchange) {
  const double seconds = std::chrono::duration<double>(Clock::now() - exchange.started).count();
  metrics_.request_ended({exchange.route, exchange.head.method, exchange.response.status, exchange.problem, seconds,
                          exchange.body.bytes(), exchange.bytes_out});
  const bool wanted =
      settings_.log_requests == "all" || (settings_.log_requests == "problems" && !exchange.problem.empty());
  if (wanted) log_request(exchange, seconds);
}

}  // namespace meshgauge::server
