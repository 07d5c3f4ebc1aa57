#include "server/observe/metrics.h"
#include "engine/hausdorff.h"

#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::server;

namespace {

// The value of the sample that this text begins, labels included; -1 when there is none.
double value_of(const Metrics& metrics, const std::string& sample) {
  const std::string text = "\n" + metrics.text();
  const std::size_t at = text.find("\n" + sample + " ");
  return at == std::string::npos ? -1 : std::stod(text.substr(at + sample.size() + 2));
}

std::size_t lines_with(const Metrics& metrics, const std::string& part) {
  const std::string text = metrics.text();
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

RequestEnd request(std::string_view route, std::string_view method, int status, std::string_view problem = "") {
  return {route, method, status, problem, 0.02, 100, 200};
}

}  // namespace

TEST_CASE("metrics: requests are counted by route, method and status") {
  Metrics metrics;
  metrics.request_ended(request("/v1/comparisons", "POST", 200));
  metrics.request_ended(request("/v1/comparisons", "POST", 200));
  metrics.request_ended(request("/v1/comparisons", "POST", 503, "/problems/overloaded"));
  CHECK(value_of(metrics, R"(meshgauge_requests_total{code="200",method="POST",route="/v1/comparisons"})") == 2);
  CHECK(value_of(metrics, R"(meshgauge_requests_total{code="503",method="POST",route="/v1/comparisons"})") == 1);
  CHECK(value_of(metrics, R"(meshgauge_rejected_total{reason="overloaded"})") == 1);
  CHECK(value_of(metrics, R"(meshgauge_rejected_total{reason="too-large"})") == 0);
  CHECK(value_of(metrics, R"(meshgauge_request_bytes_total{route="/v1/comparisons"})") == 300);
  CHECK(value_of(metrics, R"(meshgauge_response_bytes_total{route="/v1/comparisons"})") == 600);
  const std::string bucket =
      R"(meshgauge_request_seconds_bucket{class="2xx",method="POST",route="/v1/comparisons",le=)";
  CHECK(value_of(metrics, bucket + "\"0.01\"}") == 0);
  CHECK(value_of(metrics, bucket + "\"0.025\"}") == 2);
  CHECK(value_of(metrics, bucket + "\"+Inf\"}") == 2);
}

TEST_CASE("metrics: a client cannot create series") {
  Metrics metrics;
  for (int i = 0; i < 100; ++i) metrics.request_ended(request("", "BREW" + std::to_string(i), 501));
  CHECK(lines_with(metrics, "\nmeshgauge_requests_total{") == 1);
  CHECK(value_of(metrics, R"(meshgauge_requests_total{code="501",method="other",route="none"})") == 100);
}

TEST_CASE("metrics: a comparison is counted once, with its stages and how much was culled") {
  Metrics metrics;
  api::Comparison comparison;
  comparison.outcome.stop = Stop::timeout;
  comparison.outcome.a_to_b = Directed{{}, {1000, 20}, {}};
  comparison.times.read_a = 2;
  comparison.a.triangles = 1000;
  comparison.b.triangles = 234;
  metrics.job_started(0.5);
  metrics.job_ended(comparison);
  CHECK(value_of(metrics, R"(meshgauge_jobs_total{state="done",status="timeout",strategy="auto"})") == 1);
  CHECK(value_of(metrics, R"(meshgauge_jobs_total{state="done",status="converged",strategy="auto"})") == 0);
  CHECK(value_of(metrics, R"(meshgauge_stage_seconds_sum{stage="read_a"})") == 0.002);
  CHECK(value_of(metrics, R"(meshgauge_stage_seconds_count{stage="certify"})") == 1);
  CHECK(value_of(metrics, "meshgauge_queue_wait_seconds_sum") == 0.5);
  CHECK(value_of(metrics, R"(meshgauge_culling_rate_bucket{le="0.95"})") == 0);
  CHECK(value_of(metrics, R"(meshgauge_culling_rate_bucket{le="0.99"})") == 1);
  CHECK(value_of(metrics, "meshgauge_culling_rate_count") == 1);
  CHECK(value_of(metrics, "meshgauge_triangles_total") == 1234);
}

TEST_CASE("metrics: the ways in which a comparison ends without an interval") {
  Metrics metrics;
  metrics.job_failed("/problems/unreadable-mesh", Strategy::four_point);
  metrics.job_cancelled_early(Strategy::automatic);
  CHECK(value_of(metrics, R"(meshgauge_jobs_total{state="failed",status="unreadable-mesh",strategy="four_point"})") ==
        1);
  CHECK(value_of(metrics, R"(meshgauge_jobs_total{state="cancelled",status="early",strategy="auto"})") == 1);
}

TEST_CASE("metrics: cache, keys and stores") {
  Metrics metrics;
  metrics.auth_failed(AuthFailure::unknown);
  metrics.store_failed(StoreFailure::full);
  CHECK(value_of(metrics, R"(meshgauge_auth_failures_total{reason="unknown"})") == 1);
  CHECK(value_of(metrics, R"(meshgauge_auth_failures_total{reason="missing"})") == 0);
  CHECK(value_of(metrics, R"(meshgauge_store_errors_total{kind="full"})") == 1);
  CHECK(value_of(metrics, R"(meshgauge_store_errors_total{kind="broken"})") == 0);
}

TEST_CASE("metrics: levels are read on scrape, and only those that are watched") {
  Metrics metrics;
  double depth = 3;
  metrics.watch(Level::queue_depth, [&] { return depth; });
  CHECK(value_of(metrics, "meshgauge_queue_depth") == 3);
  depth = 4;
  CHECK(value_of(metrics, "meshgauge_queue_depth") == 4);
  CHECK(value_of(metrics, "meshgauge_mesh_cache_bytes") == -1);
  metrics.watch_sandbox([] {
    sandbox::Counters counters;
    counters.started = 9;
    counters[sandbox::End::crashed] = 2;
    counters[sandbox::End::lost] = 1;
    return counters;
  });
  CHECK(value_of(metrics, "meshgauge_sandbox_workers_started_total") == 9);
  CHECK(value_of(metrics, R"(meshgauge_sandbox_workers_ended_total{outcome="crashed"})") == 2);
  CHECK(value_of(metrics, R"(meshgauge_sandbox_workers_ended_total{outcome="lost"})") == 1);
}

TEST_CASE("metrics: every level has a name and help of its own") {
  Metrics metrics;
  for (int i = 0; i <= static_cast<int>(Level::disk_free_bytes); ++i) {
    metrics.watch(static_cast<Level>(i), [] { return 1.0; });
  }
  const std::size_t before = lines_with(Metrics(), "# TYPE ");
  CHECK(lines_with(metrics, "# TYPE ") == before + static_cast<std::size_t>(Level::disk_free_bytes) + 1);
  CHECK(lines_with(metrics, "# HELP  ") == 0);
}

TEST_CASE("metrics: the process and the version") {
  const Metrics metrics;
  CHECK(value_of(metrics, "meshgauge_build_info{version=\"" + std::string(version()) + "\"}") == 1);
  CHECK(value_of(metrics, "process_resident_memory_bytes") > 1e6);
  CHECK(value_of(metrics, "process_open_fds") >= 3);
  CHECK(value_of(metrics, "process_max_fds") >= value_of(metrics, "process_open_fds"));
  CHECK(value_of(metrics, "process_threads") >= 1);
  CHECK(value_of(metrics, "process_cpu_seconds_total") > 0);
  const double started = value_of(metrics, "process_start_time_seconds");
  const auto now = static_cast<double>(std::time(nullptr));
  CHECK(started > now - 3600);
  CHECK(started < now + 60);
}

TEST_CASE("metrics: counting from many threads loses nothing, while others read") {
  Metrics metrics;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&metrics, t] {
      for (int i = 0; i < 1000; ++i) metrics.request_ended(request("/", "GET", 200 + t % 2));
    });
  }
  threads.emplace_back([&metrics] {
    for (int i = 0; i < 50; ++i) CHECK(!metrics.text().empty());
  });
  for (std::thread& thread : threads) thread.join();
  CHECK(value_of(metrics, R"(meshgauge_requests_total{code="200",method="GET",route="/"})") == 2000);
  CHECK(value_of(metrics, R"(meshgauge_requests_total{code="201",method="GET",route="/"})") == 2000);
}
