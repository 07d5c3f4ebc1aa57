#include "server/sandbox/spawner.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>
#include <vector>

#include "server/sandbox/channel.h"
#include "server/sandbox/confine.h"

namespace meshgauge::server::sandbox {
namespace {

constexpr int kNotForPeople = 3;

struct Child {
  pid_t pid = 0;
  Descriptor life;  // closed by the server when it no longer needs the worker
  bool killed = false;
};

class Spawner {
 public:
  explicit Spawner(Read read) : read_(read) {}

  bool prepare(const std::string& small);
  bool wait_and_serve();  // false: the server is gone

 private:
  void spawn(const Bounds& bounds, Descriptor channel, Descriptor life);
  [[noreturn]] void become_worker(const Bounds& bounds, int channel, int life, int parent);
  void reap();

  const Read read_;
  const Rules rules_ = compile_rules();
  Descriptor ended_;  // readable when a child has ended
  std::vector<Child> children_;
};

bool is_channel(int fd) {
  int type = 0;
  socklen_t size = sizeof type;
  return ::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_SEQPACKET;
}

// Asks the kernel to kill workers before the server when memory runs out. May fail.
void ask_to_be_killed_first() {
  const Descriptor file(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
  [[maybe_unused]] const ssize_t written = ::write(file.get(), "500", 3);
}

bool Spawner::prepare(const std::string& small) {
  // Signals of a terminal or supervisor are for the server, which ends this process after its own work.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) ::signal(signal, SIG_IGN);
  ::signal(SIGCHLD,
           SIG_DFL);  // if it were ignored, as inherited from the server's parent, children could not be waited for
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  ask_to_be_killed_first();
  const auto order = receive_message(kControl, 0);
  const auto bounds = order ? decode_bounds(order->bytes) : std::nullopt;
  if (!bounds) return false;
  Trial trial =
      drop_capabilities() ? try_confinement(*bounds, rules_) : Trial{"capabilities cannot be given up", "", ""};
  trial.small = small;
  sigset_t child_ended;
  sigemptyset(&child_ended);
  sigaddset(&child_ended, SIGCHLD);
  ::sigprocmask(SIG_BLOCK, &child_ended, nullptr);
  ended_ = Descriptor(::signalfd(-1, &child_ended, SFD_CLOEXEC | SFD_NONBLOCK));
  return ended_ && send_message(kControl, encode(trial));
}

// A worker keeps only its channel. Descriptors are closed one by one, since close_range() is not available
// everywhere.
void Spawner::become_worker(const Bounds& bounds, int channel, int life, int parent) {
  if (::dup2(channel, kChannel) < 0) ::_exit(kNotConfined);  // replaces kControl
  ::close(channel);
  ::close(life);
  ::close(ended_.get());
  for (const Child& sibling : children_) ::close(sibling.life.get());
  run_worker(read_, bounds, rules_, parent);
}

void Spawner::spawn(const Bounds& bounds, Descriptor channel, Descriptor life) {
  const pid_t self = ::getpid();
  const pid_t pid = ::fork();
  if (pid == 0) become_worker(bounds, channel.get(), life.get(), self);
  if (pid > 0) children_.push_back({pid, std::move(life), false});
  // If fork failed, both channels close, which tells the server.
}

void Spawner::reap() {
  signalfd_siginfo news{};
  while (::read(ended_.get(), &news, sizeof news) > 0) {
  }
  int status = 0;
  for (pid_t pid = 0; (pid = ::waitpid(-1, &status, WNOHANG)) > 0;) {
    const auto child = std::find_if(children_.begin(), children_.end(), [&](const Child& c) { return c.pid == pid; });
    if (child == children_.end()) continue;
    send_message(child->life.get(), {reinterpret_cast<const char*>(&status), sizeof status});
    children_.erase(child);
  }
}

bool Spawner::wait_and_serve() {
  std::vector<pollfd> waits{{kControl, POLLIN, 0}, {ended_.get(), POLLIN, 0}};
  for (const Child& child : children_) waits.push_back({child.killed ? -1 : child.life.get(), POLLIN, 0});
  if (::poll(waits.data(), waits.size(), -1) < 0) return errno == EINTR;
  // A server never sends on these, so a readable one is closed.
  for (std::size_t i = 0; i < children_.size(); ++i) {
    if (waits[i + 2].revents == 0) continue;
    ::kill(children_[i].pid, SIGKILL);
    children_[i].killed = true;
  }
  if (waits[1].revents != 0) reap();
  if (waits[0].revents == 0) return true;
  auto order = receive_message(kControl, 2);
  if (!order) return false;
  const auto bounds = decode_bounds(order->bytes);
  if (bounds) spawn(*bounds, std::move(order->files[0]), std::move(order->files[1]));
  return bounds.has_value();
}

}  // namespace

int run_spawner(Read read, const std::string& small) {
  if (!is_channel(kControl)) {
    std::fputs("meshgauge: this command is the server's own; it starts it to read uploads\n", stderr);
    return kNotForPeople;
  }
  Spawner spawner(read);
  if (!spawner.prepare(small)) return 1;
  while (spawner.wait_and_serve()) {
  }
  return 0;
}

}  // namespace meshgauge::server::sandbox
