// The cost of counting, logging and tracing a request: microseconds of a call on one thread, and the time of /metrics.
#include <chrono>
#include <cstdio>
#include <functional>

#include "api/result/response.h"
#include "server/observe/log.h"
#include "server/observe/metrics.h"

using namespace meshgauge;
using namespace meshgauge::server;

namespace {

void measure(const char* what, int calls, const std::function<void()>& call) {
  const auto start = Clock::now();
  for (int i = 0; i < calls; ++i) call();
  const double us = std::chrono::duration<double, std::micro>(Clock::now() - start).count() / calls;
  std::printf("%-52s %8.2f us\n", what, us);
}

}  // namespace

int main() {
  Metrics metrics;
  api::Comparison comparison;
  comparison.outcome.a_to_b = Directed{{}, {1000, 20}, {}};
  comparison.outcome.b_to_a = comparison.outcome.a_to_b;
  const RequestEnd request{"/v1/comparisons", "POST", 200, "", 0.01, 100'000, 2000};
  const RequestEnd refused{"/v1/comparisons", "POST", 503, "/problems/overloaded", 0.01, 0, 300};

  Head head;
  head.method = "POST";
  head.path = "/v1/comparisons";
  head.headers = {{"host", "localhost"},
                  {"traceparent", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"},
                  {"tracestate", "rojo=00f067aa0ba902b7,congo=t61rcWkgMzE"}};
  Connection connection(-1);
  Body body(connection, head, 0);
  Exchange exchange("0123456789abcdef0123456789abcdef", head, body);
  exchange.route = head.path;
  const auto stages = api::stages(comparison);
  exchange.stages.assign(stages.begin(), stages.end());
  exchange.triangles = MeshSizes{comparison.a.triangles, comparison.b.triangles};

  constexpr int kCalls = 100'000;
  measure("a request counted", kCalls, [&] { metrics.request_ended(request); });
  measure("a refused request counted", kCalls, [&] { metrics.request_ended(refused); });
  measure("a comparison counted", kCalls, [&] {
    metrics.job_started(0.001);
    metrics.job_ended(comparison);
  });
  measure("a trace taken up and handed on", kCalls, [&] {
    if (trace_headers(continue_trace(head)).empty()) std::abort();
  });
  measure("a comparison's line of the log, not written", kCalls, [&] {
    if (request_line(exchange, 0.0123).empty()) std::abort();
  });
  measure("/metrics", 1000, [&] {
    if (metrics.text().empty()) std::abort();
  });
}
