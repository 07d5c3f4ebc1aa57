#include "check/run/run.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "check/run/gates.h"
#include "engine/hausdorff.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

// Measures what a function says.
class Fake : public Measurer {
 public:
  std::function<Result<Measured>(const Gate&, Control&)> answer = [](const Gate&, Control&) {
    return Result<Measured>(measured(0, 1, 2));
  };
  unsigned seats = 1;

  unsigned at_once() const override { return seats; }
  void measure(std::span<const Task> tasks) override {
    for (const Task& task : tasks) task.ended(measured_by(task), std::nullopt);
  }

  std::vector<std::string> began;

 protected:
  Result<Measured> measured_by(const Task& task) {
    {
      const std::lock_guard lock(mutex_);
      began.push_back(task.gate->name);
    }
    return answer(*task.gate, *task.control);
  }

 private:
  std::mutex mutex_;
};

Gate named(const std::string& name) {
  Gate made = gate("candidate", "baseline", 1);
  made.name = name;
  return made;
}

// Until it is cancelled.
Result<Measured> patient(Control& control) {
  while (control.check() == Interruption::none) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return measured(1, 3, 2, "cancelled");
}

}  // namespace

TEST_CASE("outcomes are in the order of the gates, whatever ends first") {
  Fake fake;
  fake.seats = 3;
  std::atomic<int> ended{0};
  fake.answer = [&](const Gate& asked, Control&) -> Result<Measured> {
    // The first waits for the others.
    while (asked.name == "one" && ended < 2) std::this_thread::yield();
    ++ended;
    return measured(0, 1, asked.name == "two" ? 2 : 0.5);
  };
  const Report report = run({named("one"), named("two"), named("three")}, fake);
  REQUIRE(report.outcomes.size() == 3);
  CHECK(report.outcomes[0].gate.name == "one");
  CHECK(report.outcomes[1].verdict() == Verdict::pass);
  CHECK(report.outcomes[2].verdict() == Verdict::undecided);
  CHECK(report.version == version());
  CHECK(!report.interrupted);
  CHECK(report.exit_code() == 2);
}

TEST_CASE("no more gates run at the same time than the measurer takes") {
  Fake fake;
  fake.seats = 2;
  std::atomic<int> now{0}, most{0};
  fake.answer = [&](const Gate&, Control&) -> Result<Measured> {
    const int here = ++now;
    int seen = most;
    while (seen < here && !most.compare_exchange_weak(seen, here)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    --now;
    return measured(0, 1, 2);
  };
  std::vector<Gate> gates;
  for (int i = 0; i < 20; ++i) gates.push_back(named(std::to_string(i)));
  CHECK(run(gates, fake).exit_code() == 0);
  CHECK(most <= 2);
  CHECK(fake.began.size() == 20);
}

TEST_CASE("an error, an exception and a timeout before there was an interval") {
  Fake fake;
  fake.answer = [](const Gate& asked, Control&) -> Result<Measured> {
    if (asked.name == "error") return Error{ErrorCode::empty_mesh, "'x' is empty", "a", ""};
    if (asked.name == "timeout") return Error{ErrorCode::out_of_time, "the time was over", "", ""};
    throw std::runtime_error("on fire");
  };
  const Report report = run({named("error"), named("exception"), named("timeout")}, fake);
  CHECK(report.outcomes[0].verdict() == Verdict::error);
  CHECK(report.outcomes[0].error->message == "'x' is empty");
  CHECK(report.outcomes[1].verdict() == Verdict::error);
  CHECK(report.outcomes[1].error->message.find("on fire") != std::string::npos);
  CHECK(report.outcomes[2].verdict() == Verdict::undecided);
  CHECK(report.outcomes[2].error.has_value());
  CHECK(!report.interrupted);
  CHECK(report.exit_code() == 3);
}

TEST_CASE("interrupted, what runs keeps its interval and the rest does not begin") {
  Fake fake;
  fake.seats = 2;
  fake.answer = [](const Gate& asked, Control& control) -> Result<Measured> {
    if (asked.name == "reading") {
      while (control.check() == Interruption::none) std::this_thread::yield();
      return Error{ErrorCode::out_of_time, "cancelled before 'x' was read", "", ""};
    }
    return patient(control);
  };
  Watch watch;
  Standing seen;
  watch.standing = [&](const Standing& standing) { seen = standing; };
  watch.interrupted = [&] { return seen.running.size() == 2; };
  const Report report = run({named("measuring"), named("reading"), named("waiting")}, fake, watch);
  CHECK(seen.gates == 3);
  CHECK(report.interrupted);
  REQUIRE(report.outcomes[0].measured);
  CHECK(report.outcomes[0].measured->upper == 3);
  for (std::size_t i = 1; i < 3; ++i) {
    CHECK(report.outcomes[i].interrupted);
    CHECK(!report.outcomes[i].error);
    CHECK(report.outcomes[i].verdict() == Verdict::undecided);
  }
  CHECK(fake.began.size() == 2);
  CHECK(report.exit_code() == 2);
}

TEST_CASE("interrupted when all was decided: the verdicts count") {
  Fake fake;
  Watch watch;
  watch.interrupted = [] { return true; };
  fake.answer = [](const Gate&, Control& control) -> Result<Measured> {
    while (control.check() == Interruption::none) std::this_thread::yield();
    return measured(0, 1, 2);  // decided in the same moment
  };
  const Report report = run({named("only")}, fake, watch);
  if (report.outcomes[0].measured) {  // it had begun
    CHECK(!report.interrupted);
    CHECK(report.exit_code() == 0);
  } else {
    CHECK(report.exit_code() == 2);
  }
}

TEST_CASE("ended() is called once for each gate, with the count") {
  Fake fake;
  fake.seats = 4;
  std::vector<std::string> told;
  std::size_t done = 0;
  Watch watch;
  watch.ended = [&](const GateOutcome& outcome, const Standing& standing) {
    told.push_back(outcome.gate.name);
    CHECK(standing.done == told.size());  // no number twice, none left out
    CHECK(standing.gates == 12);
    done = standing.done;
  };
  std::vector<Gate> gates;
  for (int i = 0; i < 12; ++i) gates.push_back(named(std::to_string(i)));
  run(gates, fake, watch);
  CHECK(std::set(told.begin(), told.end()).size() == 12);
  CHECK(told.size() == 12);
  CHECK(done == 12);
}

TEST_CASE("after() is called for every gate that began, and may fail") {
  Fake fake;
  fake.answer = [](const Gate& asked, Control&) -> Result<Measured> {
    if (asked.name == "error") return Error{};
    return measured(0, 1, 2);
  };
  std::vector<std::size_t> places;
  Watch watch;
  watch.after = [&](std::size_t place, const GateOutcome& outcome, Control& control) {
    CHECK(outcome.measured.has_value() == (place != 1));
    CHECK(control.check() == Interruption::none);
    places.push_back(place);
    throw std::runtime_error("no picture");
  };
  const Report report = run({named("a"), named("error"), named("b")}, fake, watch);
  CHECK(places == std::vector<std::size_t>{0, 1, 2});
  CHECK(report.count(Verdict::pass) == 2);
}

TEST_CASE("an exception of ended() reaches the caller after all gates have stopped") {
  Fake fake;
  fake.seats = 2;
  std::atomic<int> running{0};
  fake.answer = [&](const Gate& asked, Control& control) -> Result<Measured> {
    if (asked.name == "quick") return measured(0, 1, 2);
    ++running;
    auto result = patient(control);
    --running;
    return result;
  };
  Watch watch;
  watch.ended = [](const GateOutcome&, const Standing&) { throw std::runtime_error("no room"); };
  CHECK_THROWS_WITH(run({named("quick"), named("patient"), named("waiting")}, fake, watch), "no room");
  CHECK(running == 0);
}

namespace {

// Measures many at once, in reverse; `left_out` is forgotten.
class Batch final : public Fake {
 public:
  std::string left_out;
  std::size_t most = 3;
  std::vector<std::size_t> sizes;

  std::size_t together() const override { return most; }
  void measure(std::span<const Task> tasks) override {
    sizes.push_back(tasks.size());
    for (auto task = tasks.rbegin(); task != tasks.rend(); ++task) {
      if (task->gate->name == left_out) continue;
      task->ended(measured_by(*task), 7.0);
    }
    if (!left_out.empty()) throw std::runtime_error("no more");
  }
};

}  // namespace

TEST_CASE("gates that are measured together") {
  const std::vector<Gate> gates{named("one"), named("two"), named("three"), named("four"), named("five")};
  for (const bool pictures : {false, true}) {
    Batch batch;
    Watch watch;
    std::atomic<int> told{0}, after{0};
    watch.ended = [&](const GateOutcome&, const Standing& standing) {
      CHECK(standing.gates == 5);
      ++told;
    };
    if (pictures) watch.after = [&](std::size_t, const GateOutcome&, Control&) { ++after; };
    batch.answer = [](const Gate& gate, Control&) -> Result<Measured> {
      if (gate.name == "two") return Error{ErrorCode::unreadable_mesh, "m", "a", ""};
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      return measured(0, 1, 2);
    };
    const Report report = run(gates, batch, watch);
    CHECK(batch.sizes == std::vector<std::size_t>{3, 2});
    CHECK(told == 5);
    CHECK(after == (pictures ? 5 : 0));
    CHECK(report.outcomes[0].wall_ms == 7.0);
    CHECK(report.outcomes[1].verdict() == Verdict::error);
    CHECK(report.count(Verdict::pass) == 4);
  }
}

TEST_CASE("a gate without a result, and an exception, among gates measured together") {
  Batch batch;
  batch.left_out = "two";
  const Report report = run({named("one"), named("two"), named("three")}, batch);
  CHECK(report.count(Verdict::pass) == 2);
  REQUIRE(report.outcomes[1].error);
  CHECK(report.outcomes[1].error->message.find("no more") != std::string::npos);
}

TEST_CASE("interrupted, all that are measured together are cancelled") {
  Batch batch;
  batch.seats = 2;
  std::atomic<bool> interrupted{false};
  batch.answer = [&](const Gate&, Control& control) {
    interrupted = true;
    return patient(control);
  };
  Watch watch;
  watch.interrupted = [&] { return interrupted.load(); };
  const Report report = run({named("one"), named("two"), named("three"), named("four")}, batch, watch);
  CHECK(report.interrupted);
  CHECK(report.count(Verdict::undecided) == 4);
}

TEST_CASE("no gates: nothing to do") {
  Fake fake;
  CHECK(run({}, fake).outcomes.empty());
}

TEST_CASE("large files begin first, and those that share one follow each other") {
  const Folder folder;
  const auto small = folder.file("small.obj", std::string(10, ' '));
  const auto large = folder.file("large.obj", std::string(1000, ' '));
  const auto largest = folder.file("largest.obj", std::string(2000, ' '));
  const auto twin = folder.file("twin.obj", std::string(1000, ' '));
  const std::vector<Gate> gates{gate(small, large, 1), gate(small, twin, 1),    gate(small, small, 1),
                                gate(large, small, 1), gate(small, largest, 1), gate(folder.path() / "none", small, 1)};
  const std::vector<std::size_t> expected{4, 0, 3, 1, 2, 5};
  CHECK(order_of(gates) == expected);
}
