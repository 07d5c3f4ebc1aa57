// Workers of several versions: any worker runs any job, and stores the result as its own version's.
#include "server/measure/live_job.h"

#include <limits>

#include "bench_of_workers.h"
#include "engine/hausdorff.h"
#include "tests/server/store/single_job.h"

using namespace meshgauge;
using namespace meshgauge::server;
using store::got;
using store::JobState;

namespace {

store::NewBatch batch_of(const store::NewJob& job, const std::string& work) {
  store::NewBatch batch;
  batch.key = {"", job.batch};
  batch.created = job.created;
  batch.items.push_back({"the only one", job, work});
  return batch;
}

store::BatchCounts counts_of(Kept& kept, const store::NewBatch& batch) {
  return got(kept.embedded.batches().insert_batch(batch)).batch.counts;
}

}  // namespace

TEST_CASE("versions: a worker runs another version's job, and the result is not found as that version's") {
  Kept kept;
  Stand stand;
  stand.released = true;
  for (const std::string content : {"mesh", "the other"}) {
    got(kept.embedded.blobs().put(store::key_of("", content), store::bytes_of(content)));
  }
  store::NewJob job = job_named("mesh", "first");
  CHECK(counts_of(kept, batch_of(job, "of a version that is not this one")).queued == 1);
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] { return has_state(kept, job.key, JobState::done); }));
  bench.worker.stop();

  job.batch = "second";
  job.key.id = "mesh again";
  CHECK(counts_of(kept, batch_of(job, "of a version that is not this one")).queued == 1);
  job.batch = "third";
  job.key.id = "mesh once more";
  CHECK(counts_of(kept, batch_of(job, work_of(job))).done == 1);
}

TEST_CASE("versions: work is the same for the same meshes, hints and options alone") {
  const store::NewJob job = job_named("mesh");
  store::NewJob same = job;
  same.key.id = "another";
  same.batch = "another";
  same.cost = 7;
  CHECK(work_of(same) == work_of(job));
  for (auto member : {&store::NewJob::mesh_a, &store::NewJob::mesh_b, &store::NewJob::hints, &store::NewJob::options}) {
    store::NewJob other = job;
    other.*member += "x";
    CHECK(work_of(other) != work_of(job));
  }
}

TEST_CASE("versions: the interval of another worker stays, if it has the same version") {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Kept kept;
  store::JobStore& jobs = kept.embedded.jobs();
  const auto key = put_job(kept, job_named("mesh"));
  const auto now = store::now();
  const auto before = store::claim_one(jobs, key, "another worker", now, now);
  REQUIRE(before.has_value());
  std::string by = version();
  store::Progress expected{2, 8, "build", version()};
  SUBCASE("the same") {}
  SUBCASE("another") {
    by = "another version";
    expected = {0, kInfinity, "build", version()};
  }
  got(heartbeat(jobs, before->token, now, {2, 8, "reduce", by}));
  got(jobs.hand_back(before->token, "", {now, now}));

  struct Beginning final : Stand {
    Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation& memory, Control& control) override {
      control.report({0, std::numeric_limits<double>::infinity(), "build"});
      return Stand::load(source, memory, control);
    }
  };
  Beginning stand;
  WorkerBench bench(kept.stores(), stand, options_of("w"));
  bench.worker.start();
  REQUIRE(eventually([&] {
    const auto progress = row_of(kept, key).progress;
    return progress && progress->stage == "build";
  }));
  CHECK(row_of(kept, key).progress == expected);
  stand.released = true;
  CHECK(eventually([&] { return has_state(kept, key, JobState::done); }));
}
