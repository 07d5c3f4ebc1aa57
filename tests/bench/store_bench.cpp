// The speed of the embedded stores on a disk: jobs inserted durably by 1, 8 and 64 threads that each wait for their
// own, the three writes of a job's life, ended jobs recorded, reads, meshes put, and the time of a start with all these
// rows.
//
//   store_bench [folder] [seconds]     the folder is made and removed: /tmp by default; 3 seconds for each figure
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "api/base/digest.h"
#include "server/store/forms/stores.h"
#include "tests/bench/store_timing.h"
#include "tests/server/store/single_job.h"

namespace {

using namespace meshgauge;
using namespace meshgauge::server::store;
using Clock = std::chrono::steady_clock;

Job ended_job(const std::string& id) {
  Job job;
  static_cast<NewJob&>(job) = new_job("owner", id);
  job.state = JobState::done;
  job.finished = job.created;
  job.expires = job.created + std::chrono::hours(1);
  job.document = usual_document();
  return job;
}

void print(const char* what, int threads, double a_second) {
  std::printf("%-34s %3d threads %10.0f /s %9.3f ms each\n", what, threads, a_second, 1e3 * threads / a_second);
}

void measure_jobs(JobStore& jobs, double seconds) {
  for (const int threads : {1, 8, 64}) {
    print("insert", threads, rate(threads, seconds, [&] {
            got(jobs.insert(new_job("owner", api::random_id())));
            return 1;
          }));
  }
  for (const int threads : {1, 8, 64}) {
    const double a_second = rate(threads, seconds, [&] {
      const Job job = ended_job(api::random_id());
      got(jobs.insert(job));
      const auto claimed = got(jobs.claim_some("bench", now(), now() + std::chrono::minutes(1), 1));
      got(finish(jobs, claimed.front().token,
                 {JobState::done, job.document, "", now(), now() + std::chrono::hours(1)}));
      return 1;
    });
    print("insert, claim, finish", threads, a_second);
  }
}

void measure_records(JobStore& jobs, double seconds) {
  const Clock::time_point start = Clock::now();
  std::uint64_t records = 0;
  for (; seconds_since(start) < seconds; ++records) {
    if (records % 8000 == 7999) got(jobs.flush());
    jobs.record(ended_job(api::random_id()));
  }
  got(jobs.flush());
  print("record, until all are durable", 1, static_cast<double>(records) / seconds_since(start));
  if (got(jobs.counts()).dropped_records != 0) std::printf("... of which some were dropped\n");
}

void measure_reads(JobStore& jobs, double seconds) {
  const Job job = ended_job(api::random_id());
  jobs.record(job);
  got(jobs.flush());
  for (const int threads : {1, 8}) {
    print("get", threads, rate(threads, seconds, [&] {
            got(jobs.get(job.key));
            return 1;
          }));
  }
  const Clock::time_point start = Clock::now();
  const Counts counts = got(jobs.counts());
  std::printf("%-34s %.2f ms with %lu ended jobs\n", "counts", 1e3 * seconds_since(start),
              static_cast<unsigned long>(counts.done));
}

void measure_blobs(BlobStore& blobs, double seconds, std::size_t bytes, int threads) {
  std::atomic<std::uint64_t> number{0};
  const double a_second = rate(threads, seconds, [&] {
    std::vector<std::byte> content(bytes);
    const std::string name = std::to_string(bytes) + " " + std::to_string(number.fetch_add(1));
    std::transform(name.begin(), name.end(), content.begin(), [](char c) { return static_cast<std::byte>(c); });
    got(blobs.put({"owner", api::sha256_hex(content)}, content));
    return 1;
  });
  print(("put " + std::to_string(bytes) + " bytes").c_str(), threads, a_second);
}

}  // namespace

int main(int count, char** arguments) {
  const std::string folder = std::string(count > 1 ? arguments[1] : "/tmp") + "/store_bench-" + api::random_id();
  const double seconds = count > 2 ? std::atof(arguments[2]) : 3;
  {
    const auto stores = got(AllStores::open_embedded({folder}));
    measure_jobs(stores->jobs(), seconds);
    measure_records(stores->jobs(), seconds);
    measure_reads(stores->jobs(), seconds);
    for (const int threads : {1, 8}) measure_blobs(stores->blobs(), seconds, 50'000, threads);
    measure_blobs(stores->blobs(), seconds, 20'000'000, 1);
  }
  const Clock::time_point start = Clock::now();
  const auto stores = got(AllStores::open_embedded({folder}));
  std::printf("%-34s %.1f ms, database of %lu bytes\n", "start", 1e3 * seconds_since(start),
              static_cast<unsigned long>(std::filesystem::file_size(folder + "/jobs.sqlite")));
  const Clock::time_point sweep = Clock::now();
  const SweptJobs swept = got(stores->jobs().sweep_jobs({now(), now()}, 10'000));
  std::printf("%-34s %.1f ms, %lu jobs removed\n", "sweep", 1e3 * seconds_since(sweep),
              static_cast<unsigned long>(swept.over_cap));
  std::filesystem::remove_all(folder);
  return 0;
}
