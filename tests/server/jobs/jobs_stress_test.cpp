// Everything at once, on a store that fails from time to time: for ThreadSanitizer, and for what must hold at the end.
#include <future>
#include <map>
#include <random>
#include "server/main/checked.h"

#include "bench_of_jobs.h"

using namespace meshgauge;
using namespace meshgauge::server;
using store::got;
using store::JobState;

namespace {

constexpr int kClients = 6;
constexpr int kRounds = 60;

// A comparison of about a millisecond.
struct Quick final : MeshLoader {
  Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation&, Control& control) override {
    if (source.input.part == "b") return stand_in(source);
    ++compared;
    for (int i = 0; i < 5 && control.check() != Interruption::cancelled; ++i) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return stand_in(source);
  }

  std::atomic<int> compared{0};
};

struct Seen {
  std::map<std::string, std::string> accepted;  // durable jobs: id to the state that the client knows
  int awaited = 0;
  int refused = 0;
};

class StressClient {
 public:
  StressClient(Bench& bench, unsigned seed) : bench_(bench), dice_(seed), name_(std::to_string(seed)) {}

  Seen run() {
    for (int i = 0; i < kRounds; ++i) begin(i);
    return seen_;
  }

 private:
  bool chance(int percent) { return std::uniform_int_distribution<int>(0, 99)(dice_) < percent; }

  void begin(int round) {
    const bool durable = chance(60);
    auto slot = bench_.jobs.admit(durable ? Jobs::Kind::durable : Jobs::Kind::awaited, "");
    if (!slot) return ++seen_.refused, void();
    std::string key;
    if (durable && chance(50)) key = "key " + std::to_string(round % 7) + " of " + std::to_string(dice_() % 2);
    auto submitted = bench_.jobs.submit(std::move(*slot), submission(key.empty() ? name_ : "same", durable, key));
    if (std::holds_alternative<Denial>(submitted)) return ++seen_.refused, void();
    if (const auto* view = std::get_if<JobView>(&submitted)) return follow(view->row.key, nullptr, true);
    const auto job = std::get<std::shared_ptr<LiveJob>>(submitted);
    follow(job->key, job, durable);
  }

  void follow(const store::JobKey& key, const std::shared_ptr<LiveJob>& job, bool durable) {
    if (durable) seen_.accepted.emplace(key.id, "accepted");
    if (job && chance(30)) job->wait_for_end(std::chrono::milliseconds(2));
    if (chance(20)) {
      const auto removed = bench_.jobs.remove(key);
      if (durable && removed && *removed == Jobs::Deleted::forgotten) seen_.accepted[key.id] = "forgotten";
    }
    if (job && !durable) {
      if (chance(20)) job->control.cancel();
      seen_.awaited += job->wait_for_end(std::chrono::seconds(60));
    }
    if (chance(50)) static_cast<void>(bench_.jobs.get(key));
    static_cast<void>(bench_.jobs.figures());
  }

  Bench& bench_;
  std::mt19937 dice_;
  const std::string name_;
  Seen seen_;
};

Settings busy() {
  Settings settings;
  settings.workers = 3;
  settings.queue = 8;
  settings.max_queued_jobs = 50;
  return checked(settings).value();
}

std::map<std::string, std::string> all_accepted(const std::vector<Seen>& all) {
  std::map<std::string, std::string> accepted;
  for (const Seen& seen : all) {
    for (const auto& [id, what] : seen.accepted) {
      if (accepted[id] != "forgotten") accepted[id] = what;
    }
  }
  return accepted;
}

std::vector<Seen> attack(Bench& bench, Kept& kept, unsigned seed, bool stop_early) {
  std::atomic<bool> over{false};
  std::thread disk([&] {
    for (bool full = false; !over; full = !full) {
      kept.jobs.full = full;
      std::this_thread::sleep_for(std::chrono::milliseconds(full ? 5 : 15));
    }
    kept.jobs.full = false;
  });
  std::vector<std::future<Seen>> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.push_back(std::async(
        std::launch::async, [&bench, seed, i] { return StressClient(bench, seed + static_cast<unsigned>(i)).run(); }));
  }
  if (stop_early) {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    bench.jobs.stop();
  }
  std::vector<Seen> all;
  for (auto& client : clients) all.push_back(client.get());
  over = true;
  disk.join();
  return all;
}

bool all_ended(Kept& kept, const std::map<std::string, std::string>& accepted) {
  return std::all_of(accepted.begin(), accepted.end(), [&](const auto& one) {
    const auto row = got(kept.embedded.jobs().get({"", one.first}));
    return !row || store::has_ended(row->state);
  });
}

void check_kept(Kept& kept, const std::map<std::string, std::string>& accepted) {
  int lost = 0;
  int unfinished = 0;
  int without_result = 0;
  for (const auto& [id, what] : accepted) {
    const auto row = got(kept.embedded.jobs().get({"", id}));
    if (!row) {
      lost += what != "forgotten";
      continue;
    }
    unfinished += !store::has_ended(row->state);
    without_result += row->state == JobState::done && row->document.find(id) == std::string::npos;
  }
  CHECK(lost == 0);
  CHECK(unfinished == 0);
  CHECK(without_result == 0);
}

}  // namespace

TEST_CASE("jobs stress: every accepted job ends, and every place is given back") {
  Kept kept;
  Quick quick;
  Bench bench(kept, quick, busy());
  const auto all = attack(bench, kept, 1, false);
  REQUIRE(eventually([&] {
    const auto figures = bench.jobs.figures();
    return figures.durable_slots + figures.awaited_slots + figures.waiting + figures.running == 0;
  }));
  const auto accepted = all_accepted(all);
  REQUIRE(eventually([&] { return all_ended(kept, accepted); }));
  check_kept(kept, accepted);
  CHECK(accepted.size() > 20);
  CHECK(quick.compared > 20);
}

TEST_CASE("jobs stress: the end of the service meanwhile loses nothing") {
  Kept kept;
  Quick quick;
  std::map<std::string, std::string> accepted;
  {
    Bench bench(kept, quick, busy());
    accepted = all_accepted(attack(bench, kept, 100, true));
  }
  Bench next(kept, quick, busy());
  REQUIRE(eventually([&] { return all_ended(kept, accepted); }));
  check_kept(kept, accepted);
}
