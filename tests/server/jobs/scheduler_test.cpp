#include "server/job_queue.h"

#include <atomic>
#include <future>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::JobQueue;

namespace {

JobQueue::Job job(std::function<void(JobQueue::Slot)> work) { return {std::make_shared<Control>(), std::move(work)}; }

}  // namespace

TEST_CASE("job queue: as many slots as workers and places, and no more") {
  JobQueue queue(1, 2);
  std::vector<JobQueue::Slot> slots;
  for (int i = 0; i < 3; ++i) {
    auto slot = queue.admit();
    REQUIRE(slot.has_value());
    slots.push_back(std::move(*slot));
  }
  CHECK(!queue.admit());
  slots.pop_back();
  CHECK(queue.admit().has_value());
}

TEST_CASE("job queue: whoever has an answer may come again") {
  JobQueue queue(1, 0);
  for (int i = 0; i < 200; ++i) {
    auto slot = queue.admit();
    REQUIRE(slot.has_value());
    std::promise<void> answered;
    queue.submit(std::move(*slot), job([&](JobQueue::Slot held) {
                   { const JobQueue::Slot done = std::move(held); }
                   answered.set_value();
                 }));
    answered.get_future().get();
  }
}

TEST_CASE("job queue: everything submitted runs, the first first") {
  std::vector<int> order;
  {
    JobQueue queue(1, 9);
    for (int i = 0; i < 10; ++i) queue.submit(*queue.admit(), job([&order, i](JobQueue::Slot) { order.push_back(i); }));
  }
  CHECK(order == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
}

TEST_CASE("job queue: cancelling reaches what runs, what waits and what comes later") {
  const auto running = std::make_shared<Control>();
  const auto waiting = std::make_shared<Control>();
  const auto later = std::make_shared<Control>();
  std::promise<void> started;
  std::atomic<int> cancelled{0};
  const auto until_cancelled = [&](const std::shared_ptr<Control>& control) {
    while (control->check() == Interruption::none) std::this_thread::yield();
    ++cancelled;
  };
  {
    JobQueue queue(1, 2);
    queue.submit(*queue.admit(), {running, [&](JobQueue::Slot) {
                                    started.set_value();
                                    until_cancelled(running);
                                  }});
    started.get_future().get();
    queue.submit(*queue.admit(), {waiting, [&](JobQueue::Slot) { until_cancelled(waiting); }});
    queue.cancel_all();
    queue.submit(*queue.admit(), {later, [&](JobQueue::Slot) { until_cancelled(later); }});
  }
  CHECK(cancelled == 3);
}
