// The storage of an owner that durable jobs take.
#include "bench_of_jobs.h"
#include "server/jobs/jobs.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::seconds;
using store::got;

TEST_CASE("jobs: its uploads are removed at its end, unless they are stored or needed by another") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto bytes = [&] { return got(kept.embedded.blobs().stored_bytes("")); };
  const std::uint64_t other = std::string("the other").size();
  const auto runs = begun(submit(bench.jobs, submission("runs", true)));
  REQUIRE(eventually([&] { return stand.running == 1; }));
  Submission by_id = submission("own", true);
  by_id.b = stored(kept, "b", "stored");
  const auto waits = begun(submit(bench.jobs, std::move(by_id)));
  const auto cancelled = begun(submit(bench.jobs, submission("cancelled", true)));
  CHECK(bytes() == 4 + other + 3 + 6 + 9);
  got(bench.jobs.remove(cancelled->key));
  CHECK(bytes() == 4 + other + 3 + 6);
  stand.released = true;
  REQUIRE(waits->wait_for_end(kLong));
  CHECK(bytes() == 6);
}

TEST_CASE("jobs: refused and repeated ones leave nothing behind") {
  Kept kept;
  Stand stand;
  Settings settings = one_worker();
  settings.max_stored_bytes = 30;
  Bench bench(kept, stand, settings);
  const auto bytes = [&] { return got(kept.embedded.blobs().stored_bytes("")); };
  begun(submit(bench.jobs, submission("first", true, "key")));
  const std::uint64_t before = bytes();
  CHECK(refusal_of(submit(bench.jobs, submission(std::string(20, 'x'), true))) == api::ProblemKind::quota_exceeded);
  CHECK(refusal_of(submit(bench.jobs, submission("second", true, "key"))) == api::ProblemKind::idempotency_key_reused);
  CHECK(bytes() == before);
  begun(submit(bench.jobs, submission("first", true, "key")));
  CHECK(bytes() == before);
  stand.released = true;
}

TEST_CASE("jobs: options are stored without their blanks, and a repetition is found by the text that was sent") {
  Kept kept;
  Stand stand;
  Bench bench(kept, stand);
  const auto sent = [&](const std::string& options) {
    Submission asked = submission("mesh", true, "key");
    asked.options = options;
    asked.request = got(api::parse_options(options));
    return submit(bench.jobs, std::move(asked));
  };
  const std::string options =
      "{ \"tolerance\":" + std::string(60'000, ' ') + "{\"absolute\": 0.1000000000000000000000} }";
  const auto job = begun(sent(options));
  CHECK(row_of(kept, job->key).options == R"({"tolerance":{"absolute":0.1}})");
  CHECK(begun(sent(options))->key == job->key);
  stand.released = true;
}

TEST_CASE("jobs: jobs that wait for a restart count after it") {
  Kept kept;
  Settings settings = one_worker();
  settings.max_stored_bytes = 30;
  {
    Stand stand;
    Bench bench(kept, stand, settings);
    begun(submit(bench.jobs, submission("first", true)));
    REQUIRE(eventually([&] { return stand.running == 1; }));
    begun(submit(bench.jobs, submission("second", true)));
  }
  Stand stand;
  Bench bench(kept, stand, settings);
  CHECK(refusal_of(submit(bench.jobs, submission(std::string(20, 'x'), true))) == api::ProblemKind::quota_exceeded);
  stand.released = true;
  CHECK(eventually([&] { return got(kept.embedded.blobs().stored_bytes("")) == 0; }));
}
