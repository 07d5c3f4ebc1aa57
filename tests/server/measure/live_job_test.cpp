#include "server/measure/live_job.h"

#include <optional>
#include <utility>

#include <doctest/doctest.h>

using namespace meshgauge::server;

TEST_CASE("live job: a client that waits for the end alone is woken by nothing else") {
  LiveJob job(store::NewJob{}, std::nullopt, MeshSource{}, MeshSource{}, false);
  int changes = 0, ends = 0;
  bool cancelled = false;
  const auto follows = job.on_change([&] { ++changes; });
  const auto waits = job.on_end([&] {
    ++ends;
    cancelled = job.control.cancelled();
  });
  job.started(1, store::now());
  job.progressed({0, 1, "traverse"});
  CHECK(changes == 2);
  CHECK(ends == 0);
  SUBCASE("it ends") {
    JobView last = job.view();
    last.row.state = store::JobState::done;
    job.ended(std::move(last));
    CHECK(job.is_over());
  }
  SUBCASE("it is handed back") {
    job.release();
    CHECK(job.is_over());
  }
  SUBCASE("its cancel is requested: a client may have to end it") {
    job.cancel();
    CHECK(cancelled);
  }
  CHECK(changes == 3);
  CHECK(ends == 1);
}
