#include "server/sandbox/spawner_client.h"

#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>

#include "server/sandbox/sandbox.h"

using namespace meshgauge;
using namespace meshgauge::server::sandbox;

namespace {

constexpr Bounds kBounds{kMemoryMiB << 20, 1 << 20, 100, true};

// A process that traces another, which then cannot be waited for by its parent as long as the tracer lives.
pid_t start_tracer(pid_t traced) {
  auto channel = open_channel();
  REQUIRE(channel);
  const pid_t tracer = ::fork();
  if (tracer == 0) {
    send_message(channel->theirs.get(), ::ptrace(PTRACE_SEIZE, traced, nullptr, nullptr) == 0 ? "1" : "0");
    for (;;) ::pause();
  }
  const auto word = receive_message(channel->ours.get(), 0);
  if (word && word->bytes == "1") return tracer;
  ::kill(tracer, SIGKILL);
  ::waitpid(tracer, nullptr, 0);
  return -1;
}

}  // namespace

TEST_CASE("spawner: waiting for killed processes is limited") {
  std::optional<SpawnerClient> spawner(std::in_place, std::vector{hostile_program()});
  REQUIRE(spawner->start(kBounds).ok());
  REQUIRE(spawners().size() == 1);
  const pid_t process = spawners().front().pid;
  const pid_t tracer = start_tracer(process);
  if (tracer < 0) {
    MESSAGE("this machine does not let one process trace another");
    return;
  }
  CHECK(spawner->start(kBounds).ok());  // in its place
  CHECK(spawner->spawn(kBounds).has_value());
  spawner.reset();
  REQUIRE(::kill(tracer, SIGKILL) == 0);
  CHECK(::waitpid(tracer, nullptr, 0) == tracer);
  CHECK(::waitpid(process, nullptr, 0) == process);  // it was left
}

TEST_CASE("spawner: an interrupted start ends and leaves nothing") {
  SpawnerClient spawner({"/bin/sleep", "1000"});
  int asked = 0;
  const auto started = spawner.start(kBounds, [&asked] { return ++asked > 3; });
  REQUIRE(!started.ok());
  CHECK(started.error().message.ends_with("it does not answer"));
  CHECK(spawner.gone());
  CHECK(!spawner.spawn(kBounds));
  CHECK(spawner.start(kBounds, [] { return true; }).error().message.ends_with("it does not answer"));
}
