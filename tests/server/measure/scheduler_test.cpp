#include "server/measure/scheduler.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::Scheduler;
using Kind = Scheduler::Kind;
using Slot = Scheduler::Slot;

namespace {

Scheduler::Task task(std::function<void(Slot)> work, std::uint64_t bytes = 0, std::string owner = "") {
  return {std::move(owner), bytes, std::chrono::hours(1), std::make_shared<Control>(), std::move(work)};
}

// Occupies the only worker until release().
class Busy {
 public:
  explicit Busy(Scheduler& scheduler, const std::string& owner = "") {
    const auto started = std::make_shared<std::promise<void>>();
    const auto wait = [started, released = released_] {
      started->set_value();
      released->get_future().get();
    };
    scheduler.submit(*scheduler.admit(Kind::awaited, owner), task([wait](Slot) { wait(); }, 0, owner));
    started->get_future().get();
  }
  void release() { released_->set_value(); }

 private:
  const std::shared_ptr<std::promise<void>> released_ = std::make_shared<std::promise<void>>();
};

// Places that clients have taken, of `limit`.
class Places {
 public:
  explicit Places(std::size_t limit) : scheduler_({1, limit, 1}) {}

  bool take(const std::string& client) {
    const bool expected = scheduler_.has_place(Kind::awaited, client);
    auto slot = scheduler_.admit(Kind::awaited, client);
    CHECK(slot.has_value() == expected);
    if (slot) slots_[client].push_back(std::move(*slot));
    return slot.has_value();
  }
  std::size_t take_most(const std::string& client) {
    std::size_t count = 0;
    while (take(client)) ++count;
    return count;
  }
  void give(const std::string& client) { slots_[client].pop_back(); }
  void give_all() { slots_.clear(); }
  std::size_t of(const std::string& client) { return slots_[client].size(); }
  std::size_t most() const {  // of one client
    std::size_t most = 0;
    for (const auto& [client, slots] : slots_) most = std::max(most, slots.size());
    return most;
  }
  std::size_t taken() const { return scheduler_.figures().awaited_slots; }

 private:
  Scheduler scheduler_;
  std::map<std::string, std::vector<Slot>> slots_;
};

// How many places a client gets within its share when others have `taken` of them.
std::size_t most_within_share(std::size_t taken, std::size_t limit) {
  std::size_t own = 0;
  while (taken + own < limit && server::within_share(own, limit - taken - own)) ++own;
  return own;
}

}  // namespace

TEST_CASE("scheduler: the number of slots of a kind is limited") {
  Scheduler scheduler({1, 3, 1});
  std::vector<Slot> slots;
  for (int i = 0; i < 3; ++i) {
    auto slot = scheduler.admit(Kind::awaited, "");
    REQUIRE(slot.has_value());
    slots.push_back(std::move(*slot));
  }
  CHECK(!scheduler.admit(Kind::awaited, ""));
  auto durable = scheduler.admit(Kind::durable, "");
  CHECK(durable.has_value());
  CHECK(!scheduler.admit(Kind::durable, ""));
  const Slot again = scheduler.admit_again("");
  CHECK(scheduler.figures().awaited_slots == 3);
  CHECK(scheduler.figures().durable_slots == 2);
  slots.pop_back();
  CHECK(scheduler.admit(Kind::awaited, "").has_value());
}

TEST_CASE("scheduler: a client with an answer gets the next slot") {
  Scheduler scheduler({1, 1, 1});
  for (int i = 0; i < 200; ++i) {
    auto slot = scheduler.admit(Kind::awaited, "");
    REQUIRE(slot.has_value());
    const auto answered = std::make_shared<std::promise<void>>();
    scheduler.submit(std::move(*slot), task([answered](Slot held) {
                       { const Slot done = std::move(held); }
                       answered->set_value();
                     }));
    answered->get_future().get();
  }
}

TEST_CASE("scheduler: jobs of one size run in order, a small one before large ones that came just before") {
  std::vector<int> order;
  {
    Scheduler scheduler({1, 20, 1});
    Busy busy(scheduler);
    const auto submit = [&](int name, std::uint64_t bytes) {
      scheduler.submit(*scheduler.admit(Kind::awaited, ""),
                       task([&order, name](Slot) { order.push_back(name); }, bytes));
    };
    submit(1, 5'000'000'000);
    submit(2, 1'000'000'000);
    for (int i = 3; i < 10; ++i) submit(i, 0);
    busy.release();
  }
  CHECK(order.size() == 9);
  CHECK(std::vector<int>(order.begin(), order.begin() + 7) == std::vector<int>{3, 4, 5, 6, 7, 8, 9});
  // Beyond the largest handicap size does not matter: these two run in order.
  CHECK(std::vector<int>(order.begin() + 7, order.end()) == std::vector<int>{1, 2});
}

TEST_CASE("scheduler: an owner with nothing running comes first") {
  std::vector<std::string> order;
  const auto all_done = std::make_shared<std::promise<void>>();
  {
    Scheduler scheduler({2, 20, 1});
    Busy first(scheduler, "greedy");
    Busy second(scheduler, "greedy");  // runs all the time
    for (const char* owner : {"greedy", "greedy", "modest"}) {
      scheduler.submit(*scheduler.admit(Kind::awaited, ""), task(
                                                                [&order, owner, all_done](Slot) {
                                                                  order.emplace_back(owner);
                                                                  if (order.size() == 3) all_done->set_value();
                                                                },
                                                                0, owner));
    }
    first.release();
    all_done->get_future().get();
    second.release();
  }
  CHECK(order == std::vector<std::string>{"modest", "greedy", "greedy"});
}

TEST_CASE("scheduler: cancel_all() cancels running, waiting and future tasks") {
  const auto running = std::make_shared<Control>();
  const auto waiting = std::make_shared<Control>();
  const auto later = std::make_shared<Control>();
  const auto started = std::make_shared<std::promise<void>>();
  std::atomic<int> cancelled{0};
  const auto until_cancelled = [&](const std::shared_ptr<Control>& control) {
    while (control->check() == Interruption::none) std::this_thread::yield();
    ++cancelled;
  };
  {
    Scheduler scheduler({1, 3, 1});
    const auto submit = [&](const std::shared_ptr<Control>& control, std::function<void(Slot)> work) {
      scheduler.submit(*scheduler.admit(Kind::awaited, ""), {"", 0, std::chrono::hours(1), control, std::move(work)});
    };
    submit(running, [&](Slot) {
      started->set_value();
      until_cancelled(running);
    });
    started->get_future().get();
    submit(waiting, [&](Slot) { until_cancelled(waiting); });
    scheduler.cancel_all();
    submit(later, [&](Slot) { until_cancelled(later); });
  }
  CHECK(cancelled == 3);
}

TEST_CASE("scheduler: one client alone gets all places of a kind, and leaves its share's rest to others") {
  Places places(18);
  CHECK(places.take_most("greedy") == 18);
  CHECK(places.take_most("other") == 3);
  CHECK(places.take_most("modest") == 1);
  CHECK(places.take_most("late") == 0);
  places.give_all();
  CHECK(places.take_most("modest") == 18);
}

TEST_CASE("scheduler: of any number of places, others find as many as when no client goes beyond its share") {
  for (std::size_t limit = 1; limit < 100; ++limit) {
    CAPTURE(limit);
    Places places(limit);
    CHECK(places.take_most("greedy") == limit);
    std::size_t taken = most_within_share(0, limit);
    for (const char* other : {"b", "c", "d", "e"}) {
      const std::size_t most = most_within_share(taken, limit);
      CHECK(places.take_most(other) == most);
      taken += most;
    }
    CHECK(places.taken() <= limit + limit / 4);
  }
}

TEST_CASE("scheduler: while two clients take all they get, both have about the same, and all places are taken") {
  Places places(18);
  places.take_most("greedy");
  CHECK(places.take_most("other") == 3);
  for (std::size_t ended = 1; ended <= 40; ++ended) {
    places.give("greedy");
    places.take_most("greedy");
    places.take_most("other");
    if (ended == 12) CHECK(places.of("other") >= 7);
    CHECK(places.taken() >= 18);
    CHECK(places.taken() <= 22);
  }
  CHECK(places.of("greedy") >= 7);
  CHECK(places.of("greedy") <= 11);
  while (places.of("other") > 0) places.give("other");
  places.take_most("greedy");
  CHECK(places.taken() == 18);
}

TEST_CASE("scheduler: of a hundred clients one without a place is refused only while others have all of them") {
  constexpr std::size_t kLimit = 18;
  Places places(kLimit);
  std::mt19937 dice(7);
  for (int step = 0; step < 20'000; ++step) {
    const std::string client = std::to_string(dice() % 2 == 0 ? dice() % 100 : dice() % 3);
    if (dice() % 2 == 0 && places.of(client) > 0) {
      places.give(client);
      continue;
    }
    const std::size_t before = places.taken();
    const bool had_none = places.of(client) == 0;
    const bool taken = places.take(client);
    CHECK(places.taken() <= kLimit + kLimit / 4);
    CHECK((taken || before >= kLimit));
    if (had_none && !taken) CHECK(before - places.most() >= kLimit / 4);
  }
  places.give_all();
  CHECK(places.take_most("greedy") == kLimit);
  std::size_t newcomers = 0;
  for (int client = 0; client < 100; ++client) newcomers += places.take(std::to_string(client));
  CHECK(newcomers == 4);
}

TEST_CASE("scheduler: what one client has beyond its share waits until others have run") {
  std::promise<void> last_ran;
  std::atomic<int> greedy_ran{0}, others_ran{0};
  Scheduler scheduler({1, 18, 1});
  Busy busy(scheduler, "greedy");
  for (int i = 1; i < 18; ++i) {
    auto slot = scheduler.admit(Kind::awaited, "greedy");
    REQUIRE(slot.has_value());
    scheduler.submit(std::move(*slot), task([&](Slot) { ++greedy_ran; }, 0, "greedy"));
  }
  CHECK(!scheduler.has_place(Kind::awaited, "greedy"));
  for (const char* other : {"b", "c", "d", "e"}) {
    auto slot = scheduler.admit(Kind::awaited, other);
    REQUIRE(slot.has_value());
    scheduler.submit(std::move(*slot), task(
                                           [&](Slot) {
                                             if (++others_ran == 4) last_ran.set_value();
                                           },
                                           0, other));
  }
  last_ran.get_future().get();
  CHECK(greedy_ran == 0);
  busy.release();
  scheduler.end();
  CHECK(greedy_ran == 17);
}

TEST_CASE("scheduler: jobs from before a restart have places, and their client's share still leaves some to others") {
  Scheduler scheduler({1, 1, 18});
  std::vector<Slot> slots;
  for (int i = 0; i < 25; ++i) slots.push_back(scheduler.admit_again("greedy"));
  CHECK(scheduler.figures().durable_slots == 25);
  CHECK(!scheduler.has_place(Kind::durable, "greedy"));
  for (int i = 0; i < 3; ++i) {
    auto slot = scheduler.admit(Kind::durable, "other");
    REQUIRE(slot.has_value());
    slots.push_back(std::move(*slot));
  }
  slots.clear();
  CHECK(scheduler.figures().durable_slots == 0);
  CHECK(scheduler.has_place(Kind::durable, "greedy"));
}

TEST_CASE("scheduler: the expected wait is the time of a job by the number before it, per worker") {
  constexpr auto kTime = std::chrono::milliseconds(40);
  Scheduler scheduler({2, 20, 1});
  CHECK(scheduler.expected_wait(10).count() == 0);  // nothing is known yet
  const auto began = Scheduler::Clock::now();
  {
    Busy first(scheduler);
    std::this_thread::sleep_for(kTime);
    CHECK(scheduler.expected_wait(9) >= kTime * 10 / 2);  // what runs has taken so long
    first.release();
    while (scheduler.figures().running > 0) std::this_thread::yield();
  }
  const auto most = std::chrono::ceil<std::chrono::milliseconds>(Scheduler::Clock::now() - began);
  CHECK(scheduler.expected_wait(9) >= kTime * 10 / 2);
  CHECK(scheduler.expected_wait(9) <= most * 10 / 2);
  CHECK(scheduler.expected_wait() <= most);
}

TEST_CASE("scheduler: a client with nothing running gets a thread while another's jobs have all workers") {
  Scheduler scheduler({2, 20, 1});
  Busy first(scheduler, "greedy"), second(scheduler, "greedy");
  std::promise<void> third_ran, guest_ran;
  std::atomic<bool> guest_done{false};
  scheduler.submit(*scheduler.admit(Kind::awaited, "greedy"), task(
                                                                  [&](Slot) {
                                                                    CHECK(guest_done);
                                                                    third_ran.set_value();
                                                                  },
                                                                  0, "greedy"));
  scheduler.submit(*scheduler.admit(Kind::awaited, "modest"), task(
                                                                  [&](Slot) {
                                                                    guest_done = true;
                                                                    guest_ran.set_value();
                                                                  },
                                                                  0, "modest"));
  guest_ran.get_future().get();
  CHECK(scheduler.figures().waiting == 1);
  first.release();
  third_ran.get_future().get();
  second.release();
}
