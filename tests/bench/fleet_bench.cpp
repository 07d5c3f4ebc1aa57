// The speed of one PostgreSQL for a fleet of workers: comparisons inserted, claimed, renewed and ended, while others
// run.
//
//   MESHGAUGE_DATABASE=... fleet_bench [seconds] [threads] [running]
//
//   seconds   of each figure; 5 by default
//   threads   each with its own connection; 32 by default
//   running   comparisons that run elsewhere meanwhile; 1000 by default
//
// Prints rows of a table: the call, calls a second, milliseconds of a call. The rows that it inserts stay in the
// database.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "api/base/digest.h"
#include "server/store/postgres/postgres_store.h"
#include "tests/bench/store_timing.h"

namespace {

using namespace meshgauge;
using namespace meshgauge::server::store;

constexpr int kOwners = 10;
constexpr std::size_t kAtOnce = 32;
constexpr std::size_t kBatch = 10'000;
constexpr auto kLease = std::chrono::seconds(75);

struct Bench {
  PostgresStore& store;
  double seconds;
  int threads;
  std::size_t running;
};

std::string some_owner() {
  static std::atomic<int> next{0};
  return "owner" + std::to_string(next.fetch_add(1) % kOwners);
}

void print(const std::string& what, int threads, double a_second, std::size_t counts_a_call = 1) {
  const double calls = a_second / static_cast<double>(counts_a_call);
  std::printf("| %s, %d at a time | %.0f | %.1f |\n", what.c_str(), threads, a_second, 1e3 * threads / calls);
  std::fflush(stdout);
}

void print_rate(const Bench& bench, const std::string& what, int threads, const std::function<std::uint64_t()>& work,
                std::size_t counts_a_call = 1) {
  print(what, threads, rate(threads, bench.seconds, work), counts_a_call);
}

std::vector<Claimed> claim(PostgresStore& store, std::size_t most) {
  const TimePoint time = store.time();
  return got(
      store.claim_some("bench", time, time + kLease, most, JobStore::Suspects::passed_over, JobStore::Clients::all));
}

std::uint64_t finish(PostgresStore& store, const std::vector<Claimed>& claimed) {
  std::vector<Finished> endings;
  const TimePoint time = store.time();
  for (const Claimed& one : claimed) {
    endings.push_back(
        {one.token, {JobState::done, usual_document(), "", time, time + std::chrono::hours(1), "pass", true}});
  }
  if (endings.empty()) return 0;
  std::uint64_t stored = 0;
  for (const bool it : got(store.finish_all(endings))) stored += it ? 1U : 0U;
  return stored;
}

std::uint64_t one_life(PostgresStore& store) {
  got(store.insert(new_job(some_owner(), api::random_id())));
  return finish(store, claim(store, 1));
}

// Jobs that run during the whole benchmark, as they would on other workers.
std::vector<Claimed> hold(const Bench& bench) {
  std::vector<Claimed> held;
  while (held.size() < bench.running) {
    got(bench.store.insert(new_job(some_owner(), api::random_id())));
    for (Claimed& one : claim(bench.store, 1)) held.push_back(std::move(one));
  }
  return held;
}

void insert_batch(PostgresStore& store, const std::string& owner) {
  NewBatch batch;
  batch.key = {owner, api::random_id()};
  batch.name = "bench";
  batch.fingerprint = std::string(64, 'f');
  batch.created = store.time();
  for (std::size_t i = 0; i < kBatch; ++i) {
    BatchItem item{"item " + std::to_string(i), new_job(owner, api::random_id()), ""};
    item.job.batch = batch.key.id;
    batch.items.push_back(std::move(item));
  }
  got(store.insert_batch(batch));
}

void measure_batches(const Bench& bench) {
  const auto start = std::chrono::steady_clock::now();
  insert_batch(bench.store, some_owner());
  std::printf("| a batch of %zu | | %.0f |\n", kBatch, 1e3 * seconds_since(start));
  for (const int threads : {1, bench.threads}) {
    for (int i = 0; i < kOwners; ++i) insert_batch(bench.store, some_owner());
    std::atomic<bool> ran_dry{false};
    const double a_second = rate(threads, bench.seconds, [&] {
      const std::uint64_t ended = finish(bench.store, claim(bench.store, kAtOnce));
      if (ended == 0) ran_dry = true;
      return ended;
    });
    print("claimed and ended " + std::to_string(kAtOnce) + " at once", threads, a_second, kAtOnce);
    if (ran_dry) std::printf("(there was too little to do: take fewer seconds)\n");
  }
}

void measure_beats(const Bench& bench, const std::vector<Claimed>& held, std::size_t together, bool progress) {
  std::atomic<std::size_t> next{0};
  const auto beat = [&] {
    std::vector<Beat> beats;
    const std::size_t first = next.fetch_add(together);
    for (std::size_t i = 0; i < together; ++i) {
      beats.push_back({held[(first + i) % held.size()].token, std::nullopt});
      if (progress) beats.back().progress = Progress{static_cast<double>(first), 1e9, "traverse"};
    }
    got(bench.store.heartbeats(beats, bench.store.time() + kLease));
    return std::uint64_t{together};
  };
  const std::string what =
      progress ? "progress, told to all" : "heartbeats, " + std::to_string(together) + " in a call";
  print_rate(bench, what, bench.threads, beat, together);
}

}  // namespace

int main(int count, char** arguments) {
  const char* database = std::getenv("MESHGAUGE_DATABASE");
  if (database == nullptr) return std::fprintf(stderr, "fleet_bench: MESHGAUGE_DATABASE names no database\n"), 1;
  PostgresSettings settings;
  settings.database = database;
  settings.call_timeout = std::chrono::seconds(30);
  const double seconds = count > 1 ? std::atof(arguments[1]) : 5;
  const int threads = count > 2 ? std::atoi(arguments[2]) : 32;
  const std::size_t running = count > 3 ? std::strtoul(arguments[3], nullptr, 10) : 1000;
  settings.max_connections = static_cast<std::size_t>(threads);
  const std::unique_ptr<PostgresStore> store = got(PostgresStore::open(settings));
  const Bench bench{*store, seconds, threads, running};
  for (const int of : {1, threads}) {
    print_rate(bench, "inserted, claimed and ended, nothing else running", of, [&] { return one_life(*store); });
  }
  const std::vector<Claimed> held = hold(bench);
  for (const int of : {1, threads}) {
    print_rate(bench, "inserted, claimed and ended, " + std::to_string(running) + " running", of,
               [&] { return one_life(*store); });
  }
  measure_beats(bench, held, 1, false);
  measure_beats(bench, held, 16, false);
  measure_beats(bench, held, 1, true);
  measure_batches(bench);
  return 0;
}
