#include "server/sandbox/spawner_client.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <thread>

#include "server/sandbox/spawner.h"

namespace meshgauge::server::sandbox {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kStartTime{30'000};
constexpr milliseconds kEndTime{1'000};  // time for killed processes to be gone; after that they are reaped later

Error not_started(const std::string& why) {
  return Error{ErrorCode::internal, "the process that reads uploads could not be started: " + why, "", ""};
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  all.reserve(texts.size() + 1);
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

// Passes only the variables that the program needs to be loaded, since others may hold secrets. LD_BIND_NOW: symbols
// are looked up once, instead of in each worker.
std::vector<std::string> environment() {
  std::vector<std::string> kept{"LD_BIND_NOW=1"};
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text(*variable);
    const std::string_view name = text.substr(0, text.find('='));
    if (name.starts_with("LD_") || name.ends_with("SAN_OPTIONS")) kept.emplace_back(text);
  }
  return kept;
}

class SpawnSettings {
 public:
  explicit SpawnSettings(int control) {
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, control, kControl);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addclosefrom_np(&actions, kControl + 1);
    posix_spawnattr_init(&attributes);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    sigset_t as_usual;
    sigemptyset(&as_usual);
    sigaddset(&as_usual, SIGXFSZ);  // which the service ignores
    posix_spawnattr_setsigdefault(&attributes, &as_usual);
    // A session and group of its own: a terminal's signals are for the server.
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSID);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }

  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
};

// Does not reap the process.
bool has_ended(pid_t pid) {
  siginfo_t ended{};
  if (::waitid(P_PID, static_cast<id_t>(pid), &ended, WEXITED | WNOHANG | WNOWAIT) != 0) return errno == ECHILD;
  return ended.si_pid == pid;
}

// Whether all processes of a group are gone: the leader, and its workers if this is process 1, which inherits
// orphans.
bool all_gone(pid_t group) {
  pid_t ended = 0;
  do {
    ended = ::waitpid(-group, nullptr, WNOHANG);
  } while (ended > 0);
  return ended < 0;
}

}  // namespace

bool ReaderProcess::gone() const { return readable(channel_.get(), milliseconds(0)); }

std::optional<int> ReaderProcess::status(milliseconds time, const Interrupted& interrupted) const {
  if (!readable(life_.get(), time, interrupted)) return std::nullopt;
  const auto news = receive_message(life_.get(), 0);
  int status = 0;
  if (!news || news->bytes.size() != sizeof status) return std::nullopt;
  std::memcpy(&status, news->bytes.data(), sizeof status);
  return status;
}

Result<Trial> SpawnerClient::start(const Bounds& bounds, const Interrupted& interrupted) {
  stop(interrupted);
  auto control = open_channel();
  if (!control) return not_started(std::strerror(errno));
  const SpawnSettings settings(control->theirs.get());
  std::vector<std::string> arguments = command_;
  std::vector<std::string> variables = environment();
  const int failed = ::posix_spawn(&pid_, command_.front().c_str(), &settings.actions, &settings.attributes,
                                   pointers(arguments).data(), pointers(variables).data());
  if (failed != 0) {
    pid_ = -1;
    return not_started(std::strerror(failed));
  }
  control_ = std::move(control->ours);
  control->theirs.close();
  send_message(control_.get(), encode(bounds));  // hear() detects a dead spawner
  auto trial = hear(interrupted);
  if (!trial) stop(interrupted);
  return trial;
}

// Receives the spawner's first message.
Result<Trial> SpawnerClient::hear(const Interrupted& interrupted) {
  if (!readable(control_.get(), kStartTime, interrupted)) return not_started("it does not answer");
  const auto message = receive_message(control_.get(), 0);
  if (!message) return not_started("it ended at once");
  auto trial = decode_trial(message->bytes);
  if (!trial) return not_started("it is another program");
  if (!trial->limits.empty()) return not_started(trial->limits);
  return std::move(*trial);
}

// After its first message the spawner sends nothing, so a readable channel is closed. A worker that was just forked
// may still hold the other end.
bool SpawnerClient::gone() const { return !control_ || readable(control_.get(), milliseconds(0)) || has_ended(pid_); }

std::optional<ReaderProcess> SpawnerClient::spawn(const Bounds& bounds) {
  if (gone()) return std::nullopt;
  auto channel = open_channel();
  auto life = open_channel();
  if (!channel || !life) return std::nullopt;
  if (!send_message(control_.get(), encode(bounds), {channel->theirs.get(), life->theirs.get()})) return std::nullopt;
  return ReaderProcess(std::move(channel->ours), std::move(life->ours));
}

void SpawnerClient::stop(const Interrupted& interrupted) {
  control_.close();
  if (pid_ > 0) {
    ::kill(-pid_, SIGKILL);  // kills the whole group: the spawner and its workers
    killed_.push_back(pid_);
    pid_ = -1;
  }
  const auto end = Control::Clock::now() + kEndTime;
  while (std::erase_if(killed_, all_gone), !killed_.empty()) {
    if (interrupted() || Control::Clock::now() >= end) return;
    std::this_thread::sleep_for(milliseconds(1));
  }
}

}  // namespace meshgauge::server::sandbox
