#include "server/jobs/watcher.h"

#include <atomic>

#include "shared_bench.h"

using namespace meshgauge;
using namespace meshgauge::server;
using std::chrono::seconds;
using store::got;
using store::JobState;
using store::Signal;

namespace {

struct Scene {
  Common common;
  store::HandSignals signals;
  Metrics metrics;
  StoreErrors store_errors{metrics};
  struct Ends final : Watcher::Listener {
    std::atomic<int> count{0};
    void ended(const LiveJob&, const store::Job&) override { ++count; }
  } ends;
  std::optional<Watcher> watcher;
  Hands hands{common};

  Scene() {
    common.jobs.tell_to(signals);
    watcher.emplace(common.jobs, store_errors, metrics, kLong, ends);
    signals.listen([this](const Signal& signal) { watcher->hear(signal); });
  }
  ~Scene() { signals.stop_listening(); }

  store::Job put(const std::string& id, bool awaited = false) {
    store::NewJob job = store::new_job("owner", id);
    job.created = common.jobs.time();
    job.expires_if_never_run = job.created + kLong;
    if (awaited) job.deadline = job.created + kLong;
    return got(common.jobs.insert(job)).job;
  }
  JobState state_of(const std::string& id) { return got(common.jobs.get({"owner", id}))->state; }
};

bool shows(const LiveJob& job, JobState state, double lower) {
  const store::Job row = job.view().row;
  return row.state == state && row.progress && row.progress->lower == lower;
}

}  // namespace

TEST_CASE("watcher: all clients of a job see the same, from its claim to its end") {
  Scene scene;
  const store::Job row = scene.put("job");
  const auto job = scene.watcher->watch(row);
  CHECK(scene.watcher->watch(row) == job);
  CHECK(job->durable);
  CHECK(job->view().row.state == JobState::queued);
  const auto claimed = scene.hands.claim();
  REQUIRE(eventually([&] { return job->view().row.state == JobState::running; }));
  CHECK(job->view().row.tries == 1);
  const auto before = job->version();
  scene.hands.beat(claimed, {0.5, 2, "traverse"});
  REQUIRE(eventually([&] { return shows(*job, JobState::running, 0.5); }));
  CHECK(job->version() > before);
  CHECK(scene.ends.count == 0);
  scene.hands.finish(claimed);
  REQUIRE(job->wait_for_end(kLong));
  CHECK(scene.ends.count == 1);
  const JobView last = job->view();
  CHECK(last.row.state == JobState::done);
  CHECK(last.row.document == Hands::document_of("job"));
  CHECK(last.timing == "queue;dur=1.500, total;dur=2.250");
  REQUIRE(last.triangles.has_value());
  CHECK(last.triangles->a == 3);
  CHECK(last.triangles->b == 4);
}

TEST_CASE("watcher: a change without a signal is found by polling") {
  Scene scene;
  scene.signals.lost = true;
  const auto job = scene.watcher->watch(scene.put("job"));
  const auto claimed = scene.hands.claim();
  scene.hands.beat(claimed, {0.5, 2, "traverse"});
  REQUIRE(eventually([&] { return shows(*job, JobState::running, 0.5); }));
  scene.hands.finish(claimed);
  CHECK(job->wait_for_end(kLong));
}

TEST_CASE("watcher: many jobs are read together") {
  Scene scene;
  const auto waiting = scene.watcher->watch(scene.put("waiting"));
  std::vector<std::shared_ptr<LiveJob>> gone;
  for (int i = 0; i < 1200; ++i) {
    store::Job row;
    static_cast<store::NewJob&>(row) = store::new_job("owner", "gone " + std::to_string(i));
    if (i % 2 == 1) row.key = {"another " + std::to_string(i), "waiting " + std::to_string(i)};
    gone.push_back(scene.watcher->watch(row));
  }
  for (const auto& job : gone) REQUIRE(job->wait_for_end(kLong));
  CHECK(waiting->view().row.state == JobState::queued);
  scene.hands.finish(scene.hands.claim());
  CHECK(waiting->wait_for_end(kLong));
}

TEST_CASE("watcher: while the store is away clients see no change, then the end") {
  Scene scene;
  const auto job = scene.watcher->watch(scene.put("job"));
  const auto claimed = scene.hands.claim();
  REQUIRE(eventually([&] { return job->view().row.state == JobState::running; }));
  scene.common.jobs.gone = true;
  scene.common.jobs.tell(Signal::Kind::missed);
  REQUIRE(eventually([&] {
    return scene.metrics.text().find(R"(meshgauge_store_errors_total{kind="unavailable"} 0)") == std::string::npos;
  }));
  CHECK(job->view().row.state == JobState::running);
  scene.signals.lost = true;
  scene.common.jobs.gone = false;
  scene.hands.finish(claimed);
  CHECK(job->wait_for_end(kLong));
}

TEST_CASE("watcher: a job that is removed before its end was seen ends as cancelled") {
  Scene scene;
  scene.signals.lost = true;
  const auto job = scene.watcher->watch(scene.put("job"));
  const auto now = scene.common.jobs.time();
  got(scene.common.jobs.request_cancel(job->key, {now, now + kLong}));
  got(scene.common.jobs.forget(job->key));
  REQUIRE(job->wait_for_end(kLong));
  CHECK(job->view().row.state == JobState::cancelled);
}

TEST_CASE("watcher: a job without its client is cancelled as soon as the store answers") {
  Scene scene;
  const auto job = scene.watcher->watch(scene.put("job", true));
  CHECK_FALSE(job->durable);
  scene.common.jobs.gone = true;
  scene.watcher->leave(job);
  scene.watcher->leave(job);
  CHECK(scene.common.embedded.jobs().get(job->key)->value().state == JobState::queued);
  scene.common.jobs.gone = false;
  CHECK(eventually([&] { return scene.state_of("job") == JobState::cancelled; }));
  CHECK(job->wait_for_end(kLong));
}

TEST_CASE("watcher: stop() releases all clients, and cancels jobs that are not durable") {
  Scene scene;
  const auto durable = scene.watcher->watch(scene.put("durable"));
  const auto awaited = scene.watcher->watch(scene.put("awaited", true));
  scene.watcher->stop();
  for (const auto& job : {durable, awaited}) {
    REQUIRE(job->wait_for_end(kLong));
    CHECK(job->view().handed_back);
    CHECK(job->view().row.state == JobState::queued);
  }
  CHECK(scene.watcher->watch(got(scene.common.jobs.get(durable->key)).value()) == nullptr);
  scene.signals.stop_listening();
  scene.watcher.reset();
  CHECK(scene.state_of("durable") == JobState::queued);
  CHECK(scene.state_of("awaited") == JobState::cancelled);
}

TEST_CASE("watcher: an interval only shrinks, also when the store loses progress") {
  store::Job row;
  static_cast<store::NewJob&>(row) = store::new_job("owner", "job");
  row.state = JobState::running;
  row.tries = 1;
  LiveJob job(row, api::Request{}, MeshSource{}, MeshSource{}, true);
  const auto shown = [&](std::optional<store::Progress> progress) {
    row.progress = std::move(progress);
    job.seen(row);
    return job.view().row.progress;
  };
  CHECK_FALSE(shown(std::nullopt).has_value());
  CHECK(shown(store::Progress{1, 5, "traverse", "v1"}) == store::Progress{1, 5, "traverse", "v1"});
  CHECK(shown(store::Progress{0.5, 4, "reduce", "v1"}) == store::Progress{1, 4, "reduce", "v1"});
  const auto version = job.version();
  row.tries = 2;
  CHECK(shown(std::nullopt) == store::Progress{1, 4, "reduce", "v1"});
  CHECK(job.view().row.tries == 2);
  CHECK(job.version() == version + 1);
  CHECK(shown(store::Progress{0, 9, "build", "v2"}) == store::Progress{0, 9, "build", "v2"});
}

TEST_CASE("watcher: a place taken while another client leaves the job is given back") {
  Scheduler scheduler({1, 1, 1});
  for (int i = 0; i < 200; ++i) {
    LiveJob job(store::new_job("owner", "job"), {}, {}, {}, false);
    auto slot = scheduler.admit(Scheduler::Kind::awaited, "");
    REQUIRE(slot);
    std::thread other([&] { job.give_places_back(); });
    job.hold_place(std::move(*slot));
    slot.reset();
    other.join();
    job.give_places_back();
    CHECK(scheduler.figures().awaited_slots == 0);
  }
}
