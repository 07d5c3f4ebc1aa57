#include "engine/thread_pool.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

using namespace meshgauge;

TEST_CASE("thread pool: every task is done once in each run, and calls of one worker never overlap") {
  for (const std::size_t size : {1UL, 2UL, 4UL, 7UL}) {
    ThreadPool pool(size);
    for (const std::size_t tasks : {0UL, 1UL, 2UL, 3UL, 100UL, 1000UL}) {
      std::vector<int> done(tasks, 0);
      std::vector<std::atomic<int>> inside(size);
      std::atomic<bool> alone{true};
      pool.run(tasks, [&](std::size_t worker, std::size_t task) {
        if (inside[worker].fetch_add(1) != 0) alone = false;
        ++done[task];
        inside[worker].fetch_sub(1);
      });
      CHECK(alone);
      CHECK(std::count(done.begin(), done.end(), 1) == static_cast<std::ptrdiff_t>(tasks));
    }
  }
}

TEST_CASE("thread pool: one thread takes the tasks in order") {
  ThreadPool pool(1);
  std::vector<std::size_t> seen;
  pool.run(50, [&](std::size_t, std::size_t task) { seen.push_back(task); });
  CHECK(std::is_sorted(seen.begin(), seen.end()));
}

TEST_CASE("thread pool: run() throws the exception of a task, and the pool stays usable") {
  for (const std::size_t size : {1UL, 2UL, 4UL}) {
    ThreadPool pool(size);
    CHECK_THROWS_AS(pool.run(100,
                             [](std::size_t, std::size_t task) {
                               if (task == 20) throw std::runtime_error("task 20");
                             }),
                    std::runtime_error);
    std::atomic<int> count{0};
    pool.run(100, [&](std::size_t, std::size_t) { ++count; });
    CHECK(count == 100);
  }
}
