#include "server/access/access.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

#include <doctest/doctest.h>

#include "server/access/keys.h"

using namespace meshgauge;
using namespace std::chrono_literals;
using api::ProblemKind;
using server::Access;
using server::Caller;
using server::Denial;
using server::JobSlot;
using server::JobTurn;
using server::Key;
using server::Scope;
using server::StorageHold;

namespace {

constexpr std::uint64_t kRoom = 1'000'000;  // of storage: more than any key's

// A keys file whose tokens are the padded ids, and clocks that the test moves.
struct House {
  House() { path = std::filesystem::temp_directory_path() / ("meshgauge-keys-" + std::to_string(::getpid())); }
  ~House() { std::filesystem::remove(path); }

  static std::string token(const std::string& id) { return id + std::string(40, '.'); }

  static Key key(const std::string& id) {
    Key key;
    key.id = id;
    key.sha256 = {server::token_sha256(token(id))};
    key.allowance = {60, 2, 2, 100};
    return key;
  }

  void write(const std::vector<Key>& keys) const {
    std::string list;
    for (const Key& k : keys) list += (list.empty() ? "" : ",") + to_json(k);
    std::ofstream(path) << "{\"keys\": [" << list << "]}";
  }

  server::AccessClocks clocks() {
    return {[this] { return steady; }, [this] { return system; }};
  }

  std::filesystem::path path;
  std::chrono::steady_clock::time_point steady{1h};
  std::chrono::system_clock::time_point system{std::chrono::sys_days(std::chrono::year(2027) / 1 / 1)};
};

server::Head with(const std::string& token) {
  server::Head head;
  head.headers = {{"authorization", "Bearer " + token}};
  return head;
}

std::string owner(const Access& access, const std::string& token) {
  const auto answer = access.authenticate(with(token));
  const auto* caller = std::get_if<Caller>(&answer);
  return caller ? caller->owner : "refused";
}

std::string header(const Denial& denial, const std::string& name) {
  for (const auto& [key, value] : denial.headers) {
    if (key == name) return value;
  }
  return "";
}

template <class T>
bool denied(const std::variant<T, Denial>& answer) {
  return std::holds_alternative<Denial>(answer);
}

}  // namespace

TEST_CASE("access: without keys every client has all scopes") {
  Access access("");
  CHECK(!access.has_keys());
  REQUIRE(access.reload().ok());
  const auto answer = access.authenticate(server::Head{});
  const auto& caller = std::get<Caller>(answer);
  CHECK(caller.owner.empty());
  CHECK(!Access::require(caller, Scope::metrics));
  for (int i = 0; i < 1000; ++i) CHECK(!access.begin_request(""));
  CHECK(!denied(access.take_job("")));
  const auto nothing = [] { return std::uint64_t{0}; };
  CHECK(!denied(access.hold_storage("", ~std::uint64_t{0}, ~std::uint64_t{0}, nothing)));
  const auto on_its_way = access.hold_storage("", 60, 100, nothing);
  CHECK(!denied(on_its_way));
  CHECK(denied(access.hold_storage("", 41, 100, nothing)));
  CHECK(!denied(access.hold_storage("", 40, 100, nothing)));
}

TEST_CASE("access: a token gives its owner, unknown, disabled and expired ones get the same response") {
  House house;
  Key off = House::key("off");
  off.disabled = true;
  Key late = House::key("late");
  late.expires = house.system + 10s;
  house.write({House::key("ci"), off, late});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().value() == 3);
  CHECK(owner(access, House::token("ci")) == "ci");
  CHECK(owner(access, House::token("late")) == "late");
  house.system += 10s;
  const auto unknown = std::get<Denial>(access.authenticate(with(House::token("stranger"))));
  CHECK(unknown.problem.status() == 401);
  CHECK(header(unknown, "WWW-Authenticate") == R"(Bearer realm="meshgauge", error="invalid_token")");
  for (const char* id : {"late", "off"}) {
    const auto denial = std::get<Denial>(access.authenticate(with(House::token(id))));
    CHECK(to_json(denial.problem) == to_json(unknown.problem));
    CHECK(denial.headers == unknown.headers);
  }
  CHECK(owner(access, "ci") == "refused");
  CHECK(owner(access, std::string(100'000, 'x')) == "refused");
  const auto none = std::get<Denial>(access.authenticate(server::Head{}));
  CHECK(none.problem.kind == ProblemKind::unauthorized);
  CHECK(header(none, "WWW-Authenticate") == R"(Bearer realm="meshgauge")");
}

TEST_CASE("access: two tokens of one key are one owner") {
  House house;
  Key key = House::key("ci");
  key.sha256.push_back(server::token_sha256(House::token("new")));
  house.write({key});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  CHECK(owner(access, House::token("ci")) == "ci");
  CHECK(owner(access, House::token("new")) == "ci");
}

TEST_CASE("access: a missing scope is forbidden, and the message names it") {
  const auto denial = Access::require({"ci", {true, false}}, Scope::metrics);
  REQUIRE(denial);
  CHECK(denial->problem.status() == 403);
  CHECK(header(*denial, "WWW-Authenticate").find(R"(scope="metrics")") != std::string::npos);
  CHECK(!Access::require({"ci", {true, false}}, Scope::compare));
  CHECK(Access::require({"ci", {false, true}}, Scope::compare));
}

TEST_CASE("access: a burst, then the rate, and Retry-After says when") {
  House house;
  Key slow = House::key("slow");
  slow.allowance.requests_per_minute = 2;
  house.write({House::key("ci"), slow});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  for (int i = 0; i < 2; ++i) CHECK(!access.begin_request("ci"));
  const auto denial = access.begin_request("ci");
  REQUIRE(denial);
  CHECK(denial->problem.status() == 429);
  CHECK(header(*denial, "Retry-After") == "1");
  house.steady += 999ms;
  CHECK(access.begin_request("ci"));
  house.steady += 1ms;
  CHECK(!access.begin_request("ci"));
  CHECK(access.begin_request("ci"));
  for (int i = 0; i < 2; ++i) CHECK(!access.begin_request("slow"));  // another key's bucket
  house.steady += 100ms;
  CHECK(header(*access.begin_request("slow"), "Retry-After") == "30");
  house.steady += 24h;
  for (int i = 0; i < 2; ++i) CHECK(!access.begin_request("slow"));
  CHECK(access.begin_request("slow"));  // an idle day fills it no further than to the burst
}

TEST_CASE("access: the jobs of a key are limited by max_jobs") {
  House house;
  house.write({House::key("ci"), House::key("other")});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  {
    const auto first = access.take_job("ci");
    auto second = access.take_job("ci");
    CHECK(!denied(first));
    REQUIRE(!denied(second));
    const auto third = access.take_job("ci");
    REQUIRE(denied(third));
    CHECK(std::get<Denial>(third).problem.status() == 429);
    CHECK(header(std::get<Denial>(third), "Retry-After") == "1");
    CHECK(!denied(access.take_job("other")));
    { const JobSlot moved = std::move(std::get<JobSlot>(second)); }
    CHECK(!denied(access.take_job("ci")));
  }
  {
    const auto adopted = std::make_unique<JobSlot>(access.adopt_job("ci"));
    const JobSlot second = access.adopt_job("ci");
    const JobSlot third = access.adopt_job("ci");  // more than it may: they were accepted before
    CHECK(denied(access.take_job("ci")));
  }
  CHECK(!denied(access.take_job("ci")));
  const JobSlot unlimited = access.adopt_job("left the file");
}

TEST_CASE("access: several processes: jobs of all count, and near the limit one new job at a time") {
  House house;
  house.write({House::key("ci"), House::key("other")});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  const auto there = [](std::uint64_t jobs) { return [jobs] { return meshgauge::Result<std::uint64_t>(jobs); }; };
  CHECK(!denied(access.await_turn("ci", there(1))));
  const auto full = access.await_turn("ci", there(2));
  REQUIRE(denied(full));
  CHECK(std::get<Denial>(full).problem.kind == ProblemKind::too_many_requests);
  CHECK(header(std::get<Denial>(full), "Retry-After") == "1");
  const auto gone = access.await_turn("ci", [] {
    return meshgauge::Result<std::uint64_t>(Error{ErrorCode::storage_unavailable, "gone", "", ""});
  });
  REQUIRE(denied(gone));
  CHECK(std::get<Denial>(gone).problem.kind == ProblemKind::storage_unavailable);
  CHECK(denied(access.await_turn("stranger", there(0))));
  CHECK(!denied(Access("").await_turn("", there(1'000'000))));

  std::atomic<std::uint64_t> stored{0};
  std::vector<std::thread> clients;
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      const auto turn = access.await_turn("ci", [&] { return meshgauge::Result<std::uint64_t>(stored.load()); });
      if (!denied(turn)) ++stored;
    });
  }
  {
    const auto turn = access.await_turn("other", there(0));  // does not wait for turns of another owner
    CHECK(!denied(turn));
  }
  for (std::thread& client : clients) client.join();
  CHECK(stored.load() == 2);
}

TEST_CASE("access: several processes: far from the limit turns overlap, near it they wait") {
  House house;
  Key wide = House::key("ci");
  wide.allowance.max_jobs = 20;
  house.write({wide});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  using Turn = std::variant<JobTurn, Denial>;
  const auto none = [] { return meshgauge::Result<std::uint64_t>(0); };
  std::vector<Turn> turns;
  for (int i = 0; i < 3; ++i) {
    turns.push_back(access.await_turn("ci", none));
    CHECK(!denied(turns.back()));
  }
  std::atomic<int> counted{0};
  std::atomic<bool> given{false};
  bool waited = false;
  std::thread fourth([&] {
    const Turn turn = access.await_turn("ci", [&] {
      waited = given;
      ++counted;
      return meshgauge::Result<std::uint64_t>(16);
    });
    CHECK(!denied(turn));
  });
  while (counted == 0) std::this_thread::yield();
  given = true;
  turns.clear();
  fourth.join();
  CHECK(counted == 2);  // the three turns that are not stored yet may be among the 16 or not
  CHECK(waited);
  CHECK(!denied(access.await_turn("ci", none)));
  CHECK(access.find_denial("ci", [] { return meshgauge::Result<std::uint64_t>(20); }));
  CHECK(!access.find_denial("ci", [] { return meshgauge::Result<std::uint64_t>(19); }));
}

TEST_CASE("access: storage counts what is stored and what is on its way") {
  House house;
  house.write({House::key("ci")});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  const auto hold = [&](std::uint64_t bytes, std::uint64_t stored) {
    return access.hold_storage("ci", bytes, kRoom, [stored] { return stored; });
  };
  CHECK(!denied(hold(100, 0)));
  const auto over = hold(101, 0);
  REQUIRE(denied(over));
  CHECK(std::get<Denial>(over).problem.kind == ProblemKind::quota_exceeded);
  CHECK(std::get<Denial>(over).problem.status() == 403);
  CHECK(denied(hold(1, 100)));
  CHECK(denied(hold(1, ~std::uint64_t{0})));
  CHECK(denied(hold(~std::uint64_t{0}, 1)));
  {
    const auto on_its_way = hold(60, 30);
    CHECK(!denied(on_its_way));
    CHECK(denied(hold(11, 30)));
    CHECK(!denied(hold(10, 30)));
  }
  CHECK(!denied(hold(70, 30)));
  const auto nothing = [] { return std::uint64_t{0}; };
  CHECK(!denied(access.hold_storage("ci", 50, 50, nothing)));  // what every owner may store is less than its own limit
  const auto too_much = access.hold_storage("ci", 51, 50, nothing);
  REQUIRE(denied(too_much));
  CHECK(std::get<Denial>(too_much).problem.detail.find("50 bytes") != std::string::npos);
}

TEST_CASE("access: a reload keeps usage and applies new limits and keys") {
  House house;
  house.write({House::key("ci"), House::key("leaves")});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  for (int i = 0; i < 2; ++i) CHECK(!access.begin_request("ci"));
  const auto job = access.take_job("ci");
  const auto leaving_job = access.take_job("leaves");
  Key changed = House::key("ci");
  changed.allowance.max_jobs = 1;
  changed.allowance.burst = 10;
  house.write({changed, House::key("comes")});
  REQUIRE(access.reload().value() == 2);
  CHECK(access.begin_request("ci"));  // the bucket is as empty as it was
  CHECK(denied(access.take_job("ci")));
  CHECK(owner(access, House::token("comes")) == "comes");
  CHECK(owner(access, House::token("leaves")) == "refused");
  REQUIRE(access.begin_request("leaves"));
  CHECK(access.begin_request("leaves")->problem.status() == 401);
  CHECK(denied(access.take_job("leaves")));
  CHECK(denied(access.hold_storage("leaves", 1, kRoom, [] { return std::uint64_t{0}; })));
}

TEST_CASE("access: an invalid file leaves the old keys in force") {
  House house;
  house.write({House::key("ci")});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  std::ofstream(house.path) << "{\"keys\": [{}]}";
  const auto reloaded = access.reload();
  REQUIRE(!reloaded.ok());
  CHECK(reloaded.error().message.find("/keys/0: the field 'id' is missing") != std::string::npos);
  CHECK(owner(access, House::token("ci")) == "ci");
  std::filesystem::remove(house.path);
  CHECK(!access.reload().ok());
  CHECK(owner(access, House::token("ci")) == "ci");
}

TEST_CASE("access: threads together take no more than the limit") {
  House house;
  Key key = House::key("ci");
  key.allowance = {1, 100, 1000, 1000};
  house.write({key});
  Access access(house.path, house.clocks());
  REQUIRE(access.reload().ok());
  std::atomic<int> requests{0};
  std::atomic<int> bytes{0};
  std::mutex mutex;
  std::vector<std::variant<StorageHold, Denial>> holds;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 100; ++k) {
        requests += !access.begin_request("ci");
        const auto job = access.take_job("ci");
        auto hold = access.hold_storage("ci", 10, kRoom, [] { return std::uint64_t{0}; });
        bytes += denied(hold) ? 0 : 10;
        if (k == 50) CHECK(access.reload().ok());
        const std::lock_guard lock(mutex);
        holds.push_back(std::move(hold));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(requests == 100);
  CHECK(bytes == 1000);
  holds.clear();
  CHECK(!denied(access.hold_storage("ci", 1000, kRoom, [] { return std::uint64_t{0}; })));
}
