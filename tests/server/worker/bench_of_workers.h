// Workers over real stores and a stand-in for the readers. Several on one store act like several processes.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "server/measure/live_job.h"
#include "server/worker/worker.h"
#include "tests/server/jobs/bench_of_jobs.h"

namespace meshgauge::server {

// Long leases and timeouts, unless a test is about them: no test depends on the speed of the machine.
inline WorkerOptions options_of(const std::string& name) {
  WorkerOptions options;
  options.name = name;
  options.lease = std::chrono::hours(1);
  options.heartbeat = std::chrono::milliseconds(20);
  options.progress = std::chrono::milliseconds(10);
  options.poll = std::chrono::milliseconds(20);
  options.openers = 1;  // so they become ready in the order of their claims
  return options;
}

inline Settings with_threads(std::uint64_t threads) {
  Settings settings = one_worker();
  settings.workers = threads;
  return settings;
}

// The parts of one process.
struct WorkerBench {
  WorkerBench(Stores stores, MeshLoader& loader, WorkerOptions options, const Settings& chosen = one_worker())
      : settings(chosen),
        threads(settings.workers),
        measuring(settings, loader, metrics, threads, memory, stores.jobs),
        scheduler({settings.workers, settings.workers, 1000}),
        worker(settings, stores, measuring, scheduler, store_errors, metrics, std::move(options)) {}

  double metric(const std::string& name) const {
    const std::string text = metrics.text();
    const auto at = text.find("\n" + name + " ");
    REQUIRE(at != std::string::npos);
    return std::stod(text.substr(at + name.size() + 2));
  }

  Settings settings;
  Metrics metrics;
  StoreErrors store_errors{metrics};
  ThreadBudget threads;
  MemoryBudget memory{std::uint64_t{1} << 30};
  Measuring measuring;
  Scheduler scheduler;
  Worker worker;
};

// Stores a job with its blobs. Its name is the content of mesh a, and the name of its file.
inline store::NewJob job_named(const std::string& name, const std::string& batch = "", std::uint64_t cost = 1000) {
  store::NewJob job;
  job.key = {"", name};
  job.mesh_a = store::key_of("", name).id;
  job.mesh_b = store::key_of("", "the other").id;
  job.hints = R"({"a":{"file_name":")" + name + R"("},"b":{}})";
  job.options = "{}";
  job.cost = cost;
  job.batch = batch;
  job.created = store::now();
  job.expires_if_never_run = job.created + std::chrono::hours(24);
  return job;
}

inline store::JobKey put_job(Kept& kept, const store::NewJob& job) {
  store::BlobStore& blobs = kept.embedded.blobs();
  const auto a = blobs.reserve({"", job.mesh_a});
  const auto b = blobs.reserve({"", job.mesh_b});
  store::got(blobs.put({"", job.mesh_a}, store::bytes_of(job.key.id)));
  store::got(blobs.put({"", job.mesh_b}, store::bytes_of("the other")));
  REQUIRE_FALSE(store::got(kept.embedded.jobs().insert(job)).existed);
  return job.key;
}

inline bool has_state(Kept& kept, const store::JobKey& key, store::JobState state) {
  return row_of(kept, key).state == state;
}

}  // namespace meshgauge::server
