#include "server/observe/metrics.h"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <sstream>
#include <string_view>
#include <tuple>
#include <vector>

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include "api/base/problem.h"
#include "api/options/names.h"
#include "api/result/response.h"
#include "server/observe/readings.h"

namespace meshgauge::server {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildHistogram;
using prometheus::Counter;
using prometheus::Family;
using prometheus::Histogram;
using prometheus::Registry;
using Buckets = Histogram::BucketBoundaries;

const Buckets kRequestSeconds{.001, .0025, .005, .01, .025, .05, .1, .25, .5, 1, 2.5, 5, 10, 30, 60, 180};
const Buckets kStageSeconds{.0001, .0003, .001, .003, .01, .03, .1, .3, 1, 3, 10, 30, 100, 180};
const Buckets kCullingRates{0, .25, .5, .75, .9, .95, .99, .999, 1};

constexpr std::array kAuthFailures{"missing", "malformed", "unknown", "forbidden"};  // in the order of AuthFailure
constexpr std::array kStoreFailures{"full", "unavailable", "broken"};                // of StoreFailure

Family<Counter>& counters(Registry& registry, const char* name, const char* help) {
  return BuildCounter().Name(name).Help(help).Register(registry);
}

Family<Histogram>& histograms(Registry& registry, const char* name, const char* help) {
  return BuildHistogram().Name(name).Help(help).Register(registry);
}

template <std::size_t N>
std::array<Counter*, N> counter_each(Family<Counter>& family, const char* label,
                                     const std::array<const char*, N>& values) {
  std::array<Counter*, N> all{};
  for (std::size_t i = 0; i < N; ++i) all[i] = &family.Add({{label, values[i]}});
  return all;
}

std::map<std::string_view, Histogram*> stage_histograms(Family<Histogram>& family) {
  std::map<std::string_view, Histogram*> all;
  for (const char* name : api::kStageNames) all[name] = &family.Add({{"stage", name}}, kStageSeconds);
  return all;
}

// In the order of api::MapKind.
std::vector<Histogram*> map_histograms(Family<Histogram>& family) {
  std::vector<Histogram*> all;
  for (const auto& format : api::kMapFormats)
    all.push_back(&family.Add({{"format", std::string(format.name)}}, kStageSeconds));
  return all;
}

// Clients can invent any number of methods; unknown ones share a label.
std::string_view known(std::string_view method) {
  constexpr std::array<std::string_view, 7> kMethods{"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};
  return std::find(kMethods.begin(), kMethods.end(), method) == kMethods.end() ? "other" : method;
}

std::string status_class(int status) { return std::to_string(status / 100) + "xx"; }

}  // namespace

struct Metrics::Series {
  using RequestView = std::tuple<std::string_view, std::string_view, int>;

  // The series of one route, method and status, looked up once.
  struct Request {
    Counter* count;
    Histogram* seconds;
    Counter* bytes_in;
    Counter* bytes_out;
  };
  struct RequestKey {
    std::string route;
    std::string method;
    int status;
  };
  struct Less {
    using is_transparent = void;
    static RequestView view(const RequestKey& key) { return {key.route, key.method, key.status}; }
    static RequestView view(const RequestView& key) { return key; }
    bool operator()(const auto& a, const auto& b) const { return view(a) < view(b); }
  };

  Request& request(std::string_view route, std::string_view method, int status);
  Counter& job(const char* state, std::string_view status, Strategy strategy);

  Registry registry;
  Family<Counter>& requests{counters(registry, "meshgauge_requests_total", "Requests answered")};
  Family<Histogram>& request_seconds{
      histograms(registry, "meshgauge_request_seconds", "Time from a request's head to the last byte of its response")};
  Family<Counter>& request_bytes{
      counters(registry, "meshgauge_request_bytes_total", "Bytes of request bodies received")};
  Family<Counter>& response_bytes{counters(registry, "meshgauge_response_bytes_total", "Bytes of responses sent")};
  Family<Counter>& rejected{
      counters(registry, "meshgauge_rejected_total", "Requests answered by a problem document, by problem")};
  std::map<std::string_view, Counter*> rejections;  // by problem; not changed after the constructor
  Family<Counter>& jobs{counters(registry, "meshgauge_jobs_total", "Comparisons that ended")};
  Histogram& queue_wait{
      histograms(registry, "meshgauge_queue_wait_seconds", "Time of comparisons in the queue").Add({}, kStageSeconds)};
  Histogram& culling{histograms(registry, "meshgauge_culling_rate",
                                "Fraction of triangles ruled out by the first pass, per one-sided search")
                         .Add({}, kCullingRates)};
  Counter& triangles{counters(registry, "meshgauge_triangles_total", "Triangles of compared meshes").Add({})};
  std::map<std::string_view, Histogram*> stages{
      stage_histograms(histograms(registry, "meshgauge_stage_seconds", "Time of each stage of a comparison"))};
  Family<Counter>& maps{counters(registry, "meshgauge_maps_total", "Deviation maps requested, by outcome")};
  Counter& maps_made{maps.Add({{"outcome", "made"}})};
  Counter& maps_failed{maps.Add({{"outcome", "failed"}})};
  Counter& maps_found{maps.Add({{"outcome", "cached"}})};
  std::vector<Histogram*> map_seconds{
      map_histograms(histograms(registry, "meshgauge_map_seconds", "Time to make a deviation map, waiting included"))};
  Counter& claimed{counters(registry, "meshgauge_worker_claimed_total", "Jobs that this worker has claimed").Add({})};
  Counter& leases_lost{counters(registry, "meshgauge_worker_leases_lost_total",
                                "Jobs that were given to another worker while this one ran them")
                           .Add({})};
  std::array<Counter*, 4> auth_failures{counter_each(
      counters(registry, "meshgauge_auth_failures_total", "Requests that failed authentication or lacked a scope"),
      "reason", kAuthFailures)};
  std::array<Counter*, 3> store_errors{
      counter_each(counters(registry, "meshgauge_store_errors_total", "Failed calls of the stores, by kind"), "kind",
                   kStoreFailures)};
  Readings readings;

  std::mutex mutex;  // guards what follows
  std::map<RequestKey, Request, Less> known_requests;
};

Metrics::Series::Request& Metrics::Series::request(std::string_view route, std::string_view method, int status) {
  const std::lock_guard lock(mutex);
  const auto found = known_requests.find(RequestView(route, method, status));
  if (found != known_requests.end()) return found->second;
  const std::string r(route), m(method);
  const Request made{
      &requests.Add({{"route", r}, {"method", m}, {"code", std::to_string(status)}}),
      &request_seconds.Add({{"route", r}, {"method", m}, {"class", status_class(status)}}, kRequestSeconds),
      &request_bytes.Add({{"route", r}}), &response_bytes.Add({{"route", r}})};
  return known_requests.emplace(RequestKey{r, m, status}, made).first->second;
}

Counter& Metrics::Series::job(const char* state, std::string_view status, Strategy strategy) {
  return jobs.Add({{"state", state},
                   {"status", std::string(status)},
                   {"strategy", std::string(api::name_of(api::kStrategies, strategy))}});
}

Metrics::Metrics() : series_(std::make_unique<Series>()) {
  // rate() misses the first event of a series that starts with it, so the usual series start at 0.
  for (const auto& stop : api::kStops) {
    series_->job(stop.value == Stop::cancelled ? "cancelled" : "done", stop.text, Strategy::automatic);
  }
  series_->job("failed", "out-of-time", Strategy::automatic);
  for (const api::ProblemRow& row : api::problem_table()) {
    series_->rejections[row.slug] = &series_->rejected.Add({{"reason", std::string(row.slug)}});
  }
}

Metrics::~Metrics() = default;

void Metrics::request_ended(const RequestEnd& request) {
  const std::string_view route = request.route.empty() ? "none" : request.route;
  const Series::Request& of = series_->request(route, known(request.method), request.status);
  of.count->Increment();
  of.seconds->Observe(request.seconds);
  of.bytes_in->Increment(static_cast<double>(request.bytes_in));
  of.bytes_out->Increment(static_cast<double>(request.bytes_out));
  if (request.problem.empty()) return;
  const auto slug = api::slug_of(request.problem);
  const auto found = series_->rejections.find(slug);  // a stored problem may be of another version
  (found != series_->rejections.end() ? *found->second : series_->rejected.Add({{"reason", std::string(slug)}}))
      .Increment();
}

void Metrics::job_started(double waited_seconds) { series_->queue_wait.Observe(waited_seconds); }

void Metrics::job_ended(const api::Comparison& comparison) {
  const Outcome& outcome = comparison.outcome;
  series_
      ->job(outcome.stop == Stop::cancelled ? "cancelled" : "done", api::name_of(api::kStops, outcome.stop),
            comparison.options.strategy)
      .Increment();
  for (const api::Stage& stage : api::stages(comparison)) series_->stages.at(stage.name)->Observe(stage.ms / 1000);
  for (const auto& side : {outcome.a_to_b, outcome.b_to_a}) {
    if (side && side->culling.triangles > 0) series_->culling.Observe(side->culling.rate());
  }
  series_->triangles.Increment(static_cast<double>(comparison.a.triangles + comparison.b.triangles));
}

void Metrics::job_failed(std::string_view problem_type, Strategy strategy) {
  series_->job("failed", api::slug_of(problem_type), strategy).Increment();
}

void Metrics::job_cancelled_early(Strategy strategy) { series_->job("cancelled", "early", strategy).Increment(); }

void Metrics::map_found() { series_->maps_found.Increment(); }

void Metrics::map_ended(api::MapKind kind, bool made, double seconds) {
  (made ? series_->maps_made : series_->maps_failed).Increment();
  if (made) series_->map_seconds[static_cast<std::size_t>(kind)]->Observe(seconds);
}

void Metrics::worker_claimed(std::size_t jobs) { series_->claimed.Increment(static_cast<double>(jobs)); }

void Metrics::worker_lease_lost() { series_->leases_lost.Increment(); }

void Metrics::auth_failed(AuthFailure why) { series_->auth_failures[static_cast<std::size_t>(why)]->Increment(); }

void Metrics::store_failed(StoreFailure why) { series_->store_errors[static_cast<std::size_t>(why)]->Increment(); }

void Metrics::watch(Level level, std::function<double()> read) { series_->readings.watch(level, std::move(read)); }

void Metrics::watch_sandbox(std::function<sandbox::Counters()> read) {
  series_->readings.watch_sandbox(std::move(read));
}

std::string Metrics::text() const {
  auto families = series_->registry.Collect();
  series_->readings.append_to(families);
  std::sort(families.begin(), families.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  std::ostringstream out;
  prometheus::TextSerializer().Serialize(out, families);
  return std::move(out).str();
}

}  // namespace meshgauge::server
