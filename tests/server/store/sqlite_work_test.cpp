// What the embedded store's statements cost, counted in steps of SQLite's machine: no clock is read.
#include <atomic>

#include <sqlite3.h>

#include "implementations.h"
#include "job_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

std::atomic<std::uint64_t> steps_of_writes{0};  // of all connections

int count_steps(unsigned, void*, void* statement, void*) {
  auto* const ended = static_cast<sqlite3_stmt*>(statement);
  if (sqlite3_stmt_readonly(ended) != 0) return 0;
  steps_of_writes += static_cast<std::uint64_t>(sqlite3_stmt_status(ended, SQLITE_STMTSTATUS_VM_STEP, 1));
  return 0;
}

int trace(sqlite3* connection, char**, const sqlite3_api_routines*) {
  return sqlite3_trace_v2(connection, SQLITE_TRACE_PROFILE, count_steps, nullptr);
}

// Counts the steps of every connection that is opened while it lives.
class Traced {
 public:
  Traced() { sqlite3_auto_extension(entry()); }
  ~Traced() { sqlite3_cancel_auto_extension(entry()); }
  Traced(const Traced&) = delete;
  Traced& operator=(const Traced&) = delete;

 private:
  static void (*entry())() { return reinterpret_cast<void (*)()>(&trace); }
};

// Steps of the sweep that removes ten of so many ended jobs.
std::uint64_t steps_of_sweep(int kept) {
  const Traced traced;
  EmbeddedForTests stores;
  JobStore& jobs = stores.jobs();
  for (int i = 0; i < kept; ++i) {
    jobs.record(ended_job("ann", std::to_string(i), at(i)));
    if (i % 50 == 49) got(jobs.flush());
  }
  got(jobs.flush());
  const std::uint64_t before = steps_of_writes;
  CHECK(got(jobs.sweep_jobs({at(1), at(2)}, static_cast<std::uint64_t>(kept) - 10)).over_cap == 10);
  return steps_of_writes - before;
}

}  // namespace

TEST_CASE("SQLite: what a sweep writes does not grow with what is kept") {
  const std::uint64_t few = steps_of_sweep(100);
  CHECK(few > 0);
  CHECK(steps_of_sweep(4000) < 2 * few);
}
