#include "server/measure/scheduler.h"

#include <atomic>
#include <future>
#include <memory>
#include <string>
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

TEST_CASE("scheduler: one client never gets all places of a kind, and two leave some, too") {
  Scheduler scheduler({1, 18, 1});
  std::vector<Slot> slots;
  const auto most_of = [&](const std::string& client) {
    for (std::size_t taken = 0;; ++taken) {
      auto slot = scheduler.admit(Kind::awaited, client);
      if (!slot) return taken;
      slots.push_back(std::move(*slot));
    }
  };
  CHECK(most_of("greedy") == 14);
  CHECK(most_of("other") == 3);
  CHECK(most_of("modest") == 1);
  slots.clear();
  CHECK(most_of("modest") == 14);
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
