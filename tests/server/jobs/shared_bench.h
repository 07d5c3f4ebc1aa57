// Front ends over shared stores, and a worker in single steps.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench_of_jobs.h"
#include "shared_store.h"
#include "tests/server/store/single_job.h"

namespace meshgauge::server {

// The stores, which outlive all processes.
struct Common {
  store::EmbeddedForTests embedded;
  store::SharedStore jobs{embedded.jobs()};
};

inline Settings of_front_end() {
  Settings settings = one_worker();
  settings.queue = 3;
  return settings;
}

// For a front end, which loads nothing.
struct LoadsNothing final : MeshLoader {
  Result<api::SharedMesh> load(const MeshSource&, MemoryReservation&, Control&) override {
    return Error{ErrorCode::internal, "a front end reads nothing", "", ""};
  }
};

// One process that accepts comparisons.
struct FrontEnd {
  explicit FrontEnd(Common& kept, Settings chosen = of_front_end(), const std::string& keys_file = "")
      : common(kept), settings(std::move(chosen)), access(keys_file) {
    store::got(access.reload());
    common.jobs.tell_to(signals);
    jobs.emplace(settings, loader,
                 Stores{common.jobs, common.embedded.meshes(), common.embedded.blobs(), signals, cache, true}, access,
                 metrics);
  }
  ~FrontEnd() {
    jobs.reset();
    common.jobs.tell_no_more(signals);
  }

  bool counted_early(int times) {
    const std::string line = R"(meshgauge_jobs_total{state="cancelled",status="early",strategy="auto"} )";
    return metrics.text().find(line + std::to_string(times)) != std::string::npos;
  }

  Common& common;
  Settings settings;
  store::HandSignals signals;
  MeshCache cache{0};
  Access access;
  Metrics metrics;
  LoadsNothing loader;
  std::optional<Jobs> jobs;
};

// A worker process, in single steps.
struct Hands {
  explicit Hands(Common& common) : jobs(common.jobs) {}

  store::Claimed claim() {
    auto claimed = store::got(jobs.claim_some("hands", jobs.time(), lease(), 1, store::JobStore::Suspects::too,
                                              store::JobStore::Clients::all));
    REQUIRE(claimed.size() == 1);
    jobs.tell(store::Signal::Kind::changed, claimed.front().token.key);
    return std::move(claimed.front());
  }
  store::Heartbeat beat(const store::Claimed& job, const store::Progress& progress) {
    return store::got(store::heartbeat(jobs, job.token, lease(), progress));
  }
  void finish(const store::Claimed& job, store::JobState state = store::JobState::done, std::string problem = "") {
    const auto now = jobs.time();
    const std::string document = problem.empty() ? document_of(job.token.key.id) : "";
    REQUIRE(store::got(store::finish(jobs, job.token, {state, document, problem, now, now + std::chrono::hours(1)})));
  }
  static std::string document_of(const std::string& id) {
    return R"({"id":")" + id +
           R"(","timings_ms":{"queue":1.5,"total":2.25},"meshes":{"a":{"triangles":3},"b":{"triangles":4}}})";
  }
  store::TimePoint lease() const { return jobs.time() + std::chrono::minutes(1); }

  store::SharedStore& jobs;
};

}  // namespace meshgauge::server
