// Readings whose worker ends, or is not to be had, through no doing of their file; and spawners that do not come back.
// What is to last is held up by a file in the way, so none of these depends on how fast the machine is.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>

#include "server/sandbox/sandbox.h"

using namespace meshgauge;
using namespace meshgauge::server;
using namespace meshgauge::server::sandbox;

using std::chrono::milliseconds;

namespace {

constexpr char kKilled[] = "the reader of 'a' was ended by signal 9 (Killed), which its file did not do\n";

// Waits for a worker that computes and is not `other`.
pid_t running_but(pid_t other) {
  pid_t found = -1;
  REQUIRE(eventually([&] {
    for (const Process& process : running()) {
      if (process.pid != other) found = process.pid;
    }
    return found > 0;
  }));
  return found;
}

void check_failed(const Result<api::LoadedMesh>& read, std::string_view message) {
  REQUIRE(!read.ok());
  CHECK(read.error().code == ErrorCode::internal);
  CHECK(read.error().message == message);
  CHECK(read.error().part.empty());
}

constexpr char kLost[] = "the process that read 'a' was lost";
constexpr char kNotRead[] = "the service could not read 'a'";

// A file that keeps the spawner of a pool from coming back, from lay() on.
class Obstacle {
 public:
  Obstacle() {
    REQUIRE(::mkdtemp(folder_.data()) != nullptr);
    path_ = folder_ + "/obstacle";
  }
  Obstacle(const Obstacle&) = delete;
  Obstacle& operator=(const Obstacle&) = delete;
  ~Obstacle() { std::filesystem::remove_all(folder_); }

  const std::string& path() const { return path_; }
  void lay() const { REQUIRE(Descriptor(::open(path_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600))); }
  void lift() const { std::filesystem::remove(path_); }

 private:
  std::string folder_ = std::filesystem::temp_directory_path() / "meshgauge.XXXXXX";
  std::string path_;
};

bool has_ended(pid_t pid) {
  const std::string state = status_line(pid, "State");
  return state.empty() || state.starts_with("Z");
}

// Waits until the spawner has forked all workers that were ordered, and each has closed the other descriptors. Until
// then a worker holds the spawner's end of the channel, and an order would be sent to a dead spawner without an error.
void await_workers(std::size_t count) {
  REQUIRE(eventually([=] {
    const auto all = workers();
    return all.size() == count &&
           std::ranges::all_of(all, [](const Process& p) { return status_line(p.pid, "NoNewPrivs") == "1"; });
  }));
}

// Stopped before, so that its workers are known: see await_workers().
void kill_spawner() {
  REQUIRE(spawners().size() == 1);
  const pid_t spawner = spawners().front().pid;
  ::kill(spawner, SIGSTOP);
  REQUIRE(eventually([=] { return status_line(spawner, "State").starts_with("T"); }));
  const std::vector<Process> its = workers();
  ::kill(spawner, SIGKILL);
  REQUIRE(eventually([=] { return has_ended(spawner); }));
  for (const Process& worker : its) REQUIRE(eventually([&] { return has_ended(worker.pid); }));
}

// As long as it lives this process can open nothing.
class NoDescriptors {
 public:
  NoDescriptors() {
    const Descriptor lowest(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    REQUIRE(::getrlimit(RLIMIT_NOFILE, &before_) == 0);
    const rlimit none{static_cast<rlim_t>(lowest.get()), before_.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &none) == 0);
  }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;
  ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

}  // namespace

TEST_CASE("lost: a file whose worker is killed is read by another") {
  Sandbox sandbox;
  sandbox.start();
  Endless endless(sandbox);
  const pid_t first = running_but(0);
  REQUIRE(::kill(first, SIGKILL) == 0);
  running_but(first);
  endless.control().cancel();
  CHECK(endless.result().error().code == ErrorCode::out_of_time);
  CHECK(sandbox.logged() == std::string(kKilled) + "the reader of 'a' was killed: cancelled\n");
  CHECK(sandbox.pool.counters()[End::lost] == 1);
  CHECK(sandbox.pool.counters()[End::cancelled] == 1);
  CHECK(sandbox.works());
}

TEST_CASE("lost: the next worker asks for memory in place of the one before") {
  struct Counting final : Memory {
    Result<std::uint64_t> take_reader(std::uint64_t bytes) override { return ++readers, bytes; }
    void end_reader() override { ++ends; }
    Result<Done> take_mesh(std::uint64_t, std::uint64_t) override { return Done{}; }
    int readers = 0, ends = 0;
  } memory;
  Sandbox sandbox;
  sandbox.start();
  Endless endless(sandbox, &memory);
  const pid_t first = running_but(0);
  REQUIRE(::kill(first, SIGKILL) == 0);
  running_but(first);
  endless.control().cancel();
  CHECK(endless.result().error().code == ErrorCode::out_of_time);
  CHECK(memory.readers == 2);
  CHECK(memory.ends == 1);
}

TEST_CASE("lost: a file that loses two workers is an internal Error, not the file's fault") {
  Sandbox sandbox;
  sandbox.start();
  Endless endless(sandbox);
  const pid_t first = running_but(0);
  REQUIRE(::kill(first, SIGKILL) == 0);
  REQUIRE(::kill(running_but(first), SIGKILL) == 0);
  check_failed(endless.result(), kLost);
  CHECK(sandbox.logged() == std::string(kKilled) + kKilled);
  CHECK(sandbox.pool.counters()[End::lost] == 2);
  CHECK(sandbox.works());
}

TEST_CASE("lost: a worker that dies with its spawner is replaced with it") {
  Sandbox sandbox;
  sandbox.start();
  Endless endless(sandbox);
  const pid_t first = running_but(0);
  await_workers(3);
  const pid_t spawner = spawners().front().pid;
  REQUIRE(::kill(spawner, SIGKILL) == 0);
  running_but(first);
  endless.control().cancel();
  CHECK(endless.result().error().code == ErrorCode::out_of_time);
  CHECK(sandbox.pool.counters()[End::cancelled] == 1);
  CHECK(sandbox.works());
  REQUIRE(eventually([] { return spawners().size() == 1; }));
  CHECK(spawners().front().pid != spawner);
}

TEST_CASE("lost: a killed spawner is detected at once, even if a child holds its channel") {
  Sandbox sandbox({hostile_program(), "clings", "x"});
  sandbox.start();
  CHECK(sandbox.works());
  const pid_t spawner = spawners().front().pid;
  REQUIRE(::kill(spawner, SIGKILL) == 0);
  REQUIRE(eventually([=] { return has_ended(spawner); }));
  CHECK(sandbox.works());
  CHECK(sandbox.pool.counters()[End::read] == 2);
  CHECK(sandbox.logged().empty());
  REQUIRE(eventually([] { return spawners().size() == 1; }));
  CHECK(spawners().front().pid != spawner);
}

TEST_CASE("lost: a worker that could not be confined is no Error of the file") {
  Sandbox sandbox;
  sandbox.start();
  check_failed(sandbox.read("unconfined"), kLost);
  CHECK(sandbox.pool.counters()[End::lost] == 2);
  CHECK(sandbox.works());
}

TEST_CASE("lost: a worker that could not be forked is no Error of the file") {
  Sandbox sandbox({hostile_program(), "forks", "4"}, 1);  // one to try, one at the start, and two more
  sandbox.start();
  for (int i = 0; i < 3; ++i) CHECK(sandbox.works());
  check_failed(sandbox.read(kTriangle), kLost);
  CHECK(sandbox.pool.counters()[End::read] == 3);
  CHECK(sandbox.pool.counters()[End::lost] == 2);
  CHECK(sandbox.logged().find("was never made") != std::string::npos);
}

TEST_CASE("lost: deadlines hold while the spawner cannot be restarted") {
  const Obstacle obstacle;
  Sandbox sandbox({hostile_program(), "hangs", obstacle.path()});
  sandbox.start();
  obstacle.lay();
  kill_spawner();
  Endless endless(sandbox);  // starts a spawner, in vain
  pid_t hung = -1;
  REQUIRE(eventually([&] {
    const auto all = spawners();
    if (all.size() == 1 && all.front().state == 'S') hung = all.front().pid;
    return hung > 0;
  }));
  CHECK(sandbox.pool.counters()[End::read] == 0);
  Control late(Control::Clock::now() + milliseconds(50));
  CHECK(sandbox.read(kTriangle, late).error().message == "timed out before 'a' was read");
  REQUIRE(spawners().size() == 1);
  CHECK(spawners().front().pid == hung);  // all that went on while it was waited for
  endless.control().cancel();
  CHECK(endless.result().error().message == "cancelled before 'a' was read");
  CHECK(sandbox.pool.counters()[End::overdue] == 1);
  CHECK(sandbox.pool.counters()[End::cancelled] == 1);
  CHECK(sandbox.pool.counters()[End::failed] == 0);
  obstacle.lift();
  CHECK(sandbox.works());
}

TEST_CASE("lost: restarts of a spawner that ends at once are paused") {
  const Obstacle obstacle;
  Sandbox sandbox({hostile_program(), "ends", obstacle.path()});
  sandbox.start();
  obstacle.lay();
  kill_spawner();
  const auto start = Control::Clock::now();
  std::string log;
  for (int i = 0; i < 4; ++i) {
    check_failed(sandbox.read(kTriangle), kNotRead);
    log += "the reader of 'a' is not there: the process that reads uploads could not be started: it ended at once\n";
  }
  CHECK(Control::Clock::now() - start >= milliseconds(50 + 100 + 200));
  CHECK(sandbox.logged() == log);
  CHECK(sandbox.pool.counters()[End::failed] == 4);
  obstacle.lift();
  CHECK(sandbox.works());
}

TEST_CASE("lost: defect() tells whether files would be read, and restarts the spawner") {
  const Obstacle obstacle;
  Sandbox sandbox({hostile_program(), "ends", obstacle.path()});
  sandbox.start();
  const auto defect = [&] {
    Control control;
    control.set_deadline(Control::Clock::now() + std::chrono::seconds(60));
    return sandbox.pool.defect(control);
  };
  for (int i = 0; i < 5; ++i) CHECK(defect().empty());
  CHECK(sandbox.works());
  obstacle.lay();
  kill_spawner();
  for (int i = 0; i < 2; ++i) {
    CHECK(defect() ==
          "a reader of uploads is not there: the process that reads uploads could not be started: it ended at once");
  }
  Control hurried;
  hurried.cancel();
  CHECK_FALSE(sandbox.pool.defect(hurried).empty());
  obstacle.lift();
  CHECK(defect().empty());
  CHECK(sandbox.works());
  const auto counters = sandbox.pool.counters();
  CHECK(counters[End::read] == 2);
  CHECK(counters[End::failed] == 0);
}

TEST_CASE("lost: defect() detects a spawner that hangs or cannot fork") {
  const auto defect = [](Sandbox& sandbox, milliseconds time) {
    Control control(Control::Clock::now() + time);
    return sandbox.pool.defect(control);
  };
  {
    Sandbox sandbox;
    sandbox.start();
    REQUIRE(eventually([] { return workers().size() == 2; }));
    const pid_t spawner = spawners().front().pid;
    REQUIRE(::kill(spawner, SIGSTOP) == 0);
    const std::string found = defect(sandbox, milliseconds(200));
    REQUIRE(::kill(spawner, SIGCONT) == 0);
    CHECK(found == "a reader of uploads was killed at the deadline");
    CHECK(defect(sandbox, std::chrono::seconds(60)).empty());
    CHECK(spawners().front().pid == spawner);
    CHECK(sandbox.works());
  }
  Sandbox sandbox({hostile_program(), "forks", "2"}, 1);  // one to try, and one at the start
  sandbox.start();
  CHECK(defect(sandbox, std::chrono::seconds(60)) ==
        "a reader of uploads ended, or was never made, unseen, which its file did not do");
  CHECK(sandbox.works());
}

TEST_CASE("lost: readings that wait for a spawner fail when it does not start and go on when it does") {
  const Obstacle obstacle;
  Sandbox sandbox({hostile_program(), "ends", obstacle.path()}, 4);
  sandbox.start();
  obstacle.lay();
  kill_spawner();
  for (const bool there : {false, true}) {
    if (there) obstacle.lift();
    std::vector<std::future<bool>> readings;
    readings.reserve(8);
    for (int i = 0; i < 8; ++i) readings.push_back(std::async(std::launch::async, [&] { return sandbox.works(); }));
    for (auto& reading : readings) CHECK(reading.get() == there);
  }
  CHECK(sandbox.pool.counters()[End::failed] == 8);
  CHECK(sandbox.pool.counters()[End::read] == 8);
  CHECK(spawners().size() == 1);
}

TEST_CASE("lost: lack of memory or descriptors is counted and logged once") {
  Sandbox sandbox;
  sandbox.start();
  REQUIRE(eventually([] { return workers().size() == 2; }));
  {
    const NoDescriptors none;
    check_failed(sandbox.read(kTriangle), kNotRead);
  }
  CHECK(sandbox.pool.counters()[End::failed] == 1);
  CHECK(sandbox.logged() == "the reader of 'a' could not be given it: memory or descriptors ran out\n");
  if (!kSanitized) {  // whose allocators end the process
    Control control;
    check_failed(sandbox.read("far too many", control, {std::uint64_t{1} << 50, 10, 1000}), kNotRead);
    CHECK(sandbox.pool.counters()[End::failed] == 2);
    CHECK(sandbox.logged().ends_with("the reader of 'a' did not get through: the service ran out of memory\n"));
  }
  CHECK(sandbox.works());
}
