// Several processes on one database: each has its own AllStores, as each has connections of its own.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

#include "batch_steps.h"
#include "server/store/postgres/control.h"
#include "tests/eventually.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;

namespace {

// The other connections of a process.
struct OtherConnections final : ConnectionHealth {
  SteadyTime newest_trouble() const override { return troubled ? std::chrono::steady_clock::now() : SteadyTime(); }

  std::atomic<bool> troubled{false};
};

// The signals that one process has received.
class Heard {
 public:
  explicit Heard(Signals& signals) : signals_(signals) {
    signals_.listen([this](const Signal& signal) {
      const std::lock_guard lock(mutex_);
      heard_.push_back(signal);
      changed_.notify_all();
    });
  }
  ~Heard() { signals_.stop_listening(); }

  // Waits for a signal, for any time.
  bool comes(Signal::Kind kind, const JobKey& job = {}) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 60s, [&] {
      return std::any_of(heard_.begin(), heard_.end(),
                         [&](const Signal& signal) { return signal.kind == kind && signal.job == job; });
    });
  }
  std::size_t number(Signal::Kind kind) {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(
        std::count_if(heard_.begin(), heard_.end(), [&](const Signal& signal) { return signal.kind == kind; }));
  }

 private:
  Signals& signals_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Signal> heard_;
};

void terminate_all(PostgresServer& server, const std::string& which = "true") {
  server.execute("SELECT pg_terminate_backend(pid, 20000) FROM pg_stat_activity WHERE datname LIKE 'd%' AND " + which);
}

}  // namespace

TEST_CASE("processes: they claim different jobs, and all of them") {
  PostgresForTests stores;
  insert(stores.batches(), new_batch("ann", "b", 150));
  for (int i = 0; i < 50; ++i)
    insert(stores.jobs(), new_job(i % 2 == 0 ? "ann" : "bob", "single " + std::to_string(i)));
  const auto other = stores.open("other");
  std::mutex mutex;
  std::set<std::string> claimed;
  std::size_t number = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([&, i] {
      JobStore& jobs = i % 2 == 0 ? stores.jobs() : other->jobs();
      while (true) {
        const auto some = jobs.claim_some("w" + std::to_string(i), at(50), at(110), 7);
        const std::lock_guard lock(mutex);
        if (!some || some->empty()) return;
        number += some->size();
        for (const Claimed& one : *some) claimed.insert(one.token.key.owner + one.token.key.id);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(number == 200);
  CHECK(claimed.size() == 200);
}

TEST_CASE("processes: a worker that was taken for dead can write nothing, through any process") {
  PostgresForTests stores;
  const auto other = stores.open("other");
  insert(stores.jobs(), new_job("ann", "1"));
  const auto first = got(stores.jobs().claim_some("w1", at(50), at(110), 1));
  REQUIRE(first.size() == 1);
  got(other->jobs().recover(std::nullopt, "its lease was over", {at(110), at(1110)}));
  const auto second = got(other->jobs().claim_some("w2", at(120), at(180), 1));
  REQUIRE(second.size() == 1);
  CHECK(second[0].job.suspected);
  CHECK_FALSE(got(finish(stores.jobs(), first[0].token, ending())));
  CHECK(got(heartbeat(stores.jobs(), first[0].token, at(300), {})) == Heartbeat::lost);
  CHECK(got(finish(other->jobs(), second[0].token, ending())));
  CHECK(job_in(stores.jobs(), {"ann", "1"}).tries == 2);
}

TEST_CASE("processes: one is on duty, and another one after its end") {
  PostgresForTests stores;
  auto first = stores.open("first");
  REQUIRE(eventually([&] { return first->jobs().on_duty(); }));
  const auto second = stores.open("second");
  for (int i = 0; i < 20; ++i) {
    CHECK_FALSE(second->jobs().on_duty());
    CHECK(first->jobs().on_duty());
    std::this_thread::sleep_for(20ms);
  }
  first.reset();
  CHECK(eventually([&] { return second->jobs().on_duty(); }));
}

TEST_CASE("processes: none is on duty soon after trouble") {
  PostgresForTests stores;
  DistributedSettings settings = stores.settings("other");
  settings.duty_grace = 1h;
  const auto patient = got(AllStores::open_distributed(settings));
  CHECK_FALSE(patient->jobs().on_duty());
  std::this_thread::sleep_for(300ms);
  CHECK_FALSE(patient->jobs().on_duty());  // and keeps no other process from it meanwhile
  CHECK(eventually([&] { return stores.jobs().on_duty(); }));
}

TEST_CASE("processes: the duty lapses for a process that does not ask for it") {
  PostgresForTests stores;
  ControlSettings settings{stores.database(), 0ms};
  settings.duty_lapse = 200ms;
  OtherConnections well;
  PgControl held_up(settings, well), other(settings, well);
  REQUIRE(eventually([&] { return held_up.on_duty(); }));
  CHECK(eventually([&] { return other.on_duty(); }));
  CHECK_FALSE(held_up.on_duty());
  CHECK(eventually([&] { return held_up.on_duty(); }));  // in its turn
}

TEST_CASE("processes: a process with trouble leaves the duty, however often it asks for it") {
  PostgresForTests stores;
  const ControlSettings settings{stores.database(), 300ms};
  OtherConnections of_first, of_second;
  PgControl first(settings, of_first), second(settings, of_second);
  REQUIRE(eventually([&] { return first.on_duty(); }));
  CHECK_FALSE(second.on_duty());
  of_first.troubled = true;
  CHECK_FALSE(first.on_duty());
  CHECK(eventually([&] { return !first.on_duty() && second.on_duty(); }));
}

TEST_CASE("processes: they have one clock, the database's") {
  PostgresForTests stores;
  const auto other = stores.open("other");
  CHECK(eventually([&] {
    const auto apart = stores.jobs().time() - other->jobs().time();
    return std::chrono::abs(apart) < 100ms;
  }));
  CHECK(std::chrono::abs(stores.jobs().time() - now()) < 60s);
}

TEST_CASE("processes: they know the database's clock from their first moment on") {
  PostgresForTests stores;
  const std::string name = stores.database().substr(stores.database().rfind('=') + 1);
  {
    const auto connection = PgConnection::open(stores.database());
    connection->execute(
        "CREATE FUNCTION public.clock_timestamp() RETURNS timestamptz LANGUAGE sql AS "
        "'SELECT pg_catalog.clock_timestamp() + interval ''1 hour'''");
    connection->execute("ALTER DATABASE " + name + " SET search_path = public, pg_catalog");
  }
  const auto behind = stores.open("behind");
  const auto ahead = behind->jobs().time() - now();
  CHECK(ahead > 50min);
  CHECK(ahead < 70min);
}

TEST_CASE("processes: signals reach all, with any bytes in the owners' names") {
  PostgresForTests stores;
  const auto other = stores.open("other");
  Heard heard(other->signals());
  JobStore& jobs = stores.jobs();
  const std::string owner = std::string("o'w\\n er\0\xff\n", 11);
  // The first signals may come before the other one listens.
  REQUIRE(eventually([&] {
    static int n = 0;
    insert(jobs, new_job("try", std::to_string(n++)));
    return heard.number(Signal::Kind::work) > 0;
  }));
  NewJob awaited = new_job(owner, "awaited");
  awaited.deadline = at(900);
  insert(jobs, awaited);
  const Token token = claimed_token(jobs, awaited.key);
  CHECK(heard.comes(Signal::Kind::changed, awaited.key));
  got(jobs.request_cancel(awaited.key, kNow));
  CHECK(heard.comes(Signal::Kind::cancel, awaited.key));

  insert(stores.batches(), new_batch("ann", "b", 1));
  end(jobs, {"ann", "b/0"}, reusable());  // in a batch: no signal
  insert(jobs, new_job(owner, "2"));
  const Token second = claimed_token(jobs, {owner, "2"});
  got(heartbeat(jobs, second, at(200), {1, 2, "traverse"}));
  CHECK(heard.comes(Signal::Kind::changed, {owner, "2"}));
  CHECK_FALSE(heard.number(Signal::Kind::missed) > 0);
  const std::size_t changed = heard.number(Signal::Kind::changed);
  CHECK(changed >= 2);

  terminate_all(PostgresServer::shared());
  CHECK(heard.comes(Signal::Kind::missed));
  insert(jobs, new_job(owner, "3"));
  CHECK(got(jobs.request_cancel({owner, "3"}, kNow)) == JobState::cancelled);
  CHECK(eventually([&] {
    static int n = 0;
    const std::string id = "again " + std::to_string(n++);
    insert(jobs, new_job("ann", id));
    got(jobs.request_cancel({"ann", id}, kNow));
    std::this_thread::sleep_for(50ms);
    return heard.number(Signal::Kind::changed) > changed;
  }));
}

TEST_CASE("processes: payloads are read back, and other texts are refused") {
  const std::string bytes("\0\x01 '\"\\\xff", 7);
  for (const Signal::Kind kind :
       {Signal::Kind::work, Signal::Kind::changed, Signal::Kind::cancel, Signal::Kind::missed}) {
    for (const JobKey& key : {JobKey{}, {"", "id"}, {bytes, bytes}, {"ann", ""}}) {
      const auto signal = signal_of(to_payload({kind, key}));
      REQUIRE(signal.has_value());
      CHECK(signal->kind == kind);
      CHECK(signal->job == key);
    }
  }
  CHECK(signal_of(to_payload({Signal::Kind::changed, {std::string(5000, 'x'), "1"}}))->kind == Signal::Kind::missed);
  for (const char* text : {"", "c", "c ", "c 00", "q 00 00", "c 0 00", "c 0G 00", "c 00 0", "cc 00 00"}) {
    CHECK_FALSE(signal_of(text).has_value());
  }
}

TEST_CASE("processes: a blob that one reserves no other removes") {
  PostgresForTests stores;
  const auto other = stores.open("other");
  const BlobKey key = key_of("ann", "x");
  const auto no = [] { return Result<bool>(false); };
  got(stores.blobs().put(key, bytes_of("x")));
  {
    const auto held = stores.blobs().reserve(key);
    CHECK_FALSE(got(other->blobs().remove_unreferenced(key, no)));
    std::vector<std::unique_ptr<const Reservations::Held>> many;
    for (int i = 0; i < 2000; ++i) {
      many.emplace_back(new Reservations::Held(stores.blobs().reserve(key_of("ann", std::to_string(i)))));
    }
    CHECK_FALSE(got(other->blobs().remove_unreferenced(key, no)));
    terminate_all(PostgresServer::shared());
    const auto after_trouble = stores.blobs().reserve(key_of("ann", "other"));  // notices it, and reserves all again
    CHECK_FALSE(got(other->blobs().remove_unreferenced(key, no)));
  }
  CHECK(got(other->blobs().remove_unreferenced(key, no)));
  CHECK_FALSE(got(stores.blobs().exists(key)));
}

TEST_CASE("processes: a mesh that one is using no other sweeps") {
  PostgresForTests stores;
  got(stores.meshes().put_mesh({{"ann", "m"}, 10, "", "", at(0), at(0), at(100)}, {100}));
  const auto user = PgConnection::open(stores.database());
  user->execute("BEGIN; UPDATE meshes SET expires = 1700000200000");  // at(200)
  Result<std::vector<BlobKey>> swept = std::vector<BlobKey>(1);
  std::thread sweeper([&] { swept = stores.meshes().sweep_meshes(at(150)); });
  CHECK(eventually([&] {
    PgRows row = PgConnection::open(stores.database())
                     ->query(
                         "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND "
                         "wait_event_type = 'Lock'");
    return row.next() && row.number(0) > 0;
  }));
  user->execute("COMMIT");
  sweeper.join();
  CHECK(got(swept).empty());
  CHECK(got(stores.meshes().get_mesh({"ann", "m"})).has_value());
  CHECK(got(stores.meshes().sweep_meshes(at(200))).size() == 1);
}
