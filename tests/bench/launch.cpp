// Runs one program under limits and reports its cost:
//
//   bench_launch LIMIT_SECONDS LIMIT_BYTES REPORT COMMAND [ARGUMENT ...]
//
// The command inherits stdin, stdout and stderr. When it has ended, REPORT holds one line of JSON: how it ended, wall,
// user and system seconds, peak resident bytes. LIMIT_BYTES is of address space (RLIMIT_AS). A command that outlives
// LIMIT_SECONDS is killed, and so is one whose launcher dies.
//
// This is a small separate program because Linux counts the parent's pages towards the peak of a process that it forks.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace {

using Clock = std::chrono::steady_clock;

// Touches memory, an eighth of the command's limit and 512 MiB at most, and frees it. The host of a virtual machine may
// have taken back what was not in use, and returns it page by page as it is touched, 1 ms a MiB or more: several times
// what a pair takes. So the command finds it there.
void fetch_memory(std::size_t limit) {
  constexpr std::size_t kMost = std::size_t{512} << 20, kPage = 4096;
  const std::size_t bytes = std::min(limit / 8, kMost);
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return;       // best effort, as all of this
  madvise(memory, bytes, MADV_HUGEPAGE);  // as the engine's large arrays
  for (std::size_t at = 0; at < bytes; at += kPage) static_cast<volatile char*>(memory)[at] = 1;
  munmap(memory, bytes);
}

[[noreturn]] void become(char** command, rlim_t bytes, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // the launcher died before it could be watched
  const rlimit memory{bytes, bytes}, no_core{0, 0};
  setrlimit(RLIMIT_AS, &memory);
  setrlimit(RLIMIT_CORE, &no_core);
  execvp(command[0], command);
  std::perror(command[0]);
  _exit(127);
}

// Returns whether the command had to be killed.
bool wait_or_kill(pid_t child, double seconds) {
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  pollfd ended{handle, POLLIN, 0};
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    const double left = std::chrono::duration<double>(until - Clock::now()).count();
    if (poll(&ended, 1, left > 0 ? static_cast<int>(1000 * left) + 1 : 0) > 0) break;
    if (left <= 0) return kill(child, SIGKILL), close(handle), true;
  }
  return close(handle), false;
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

bool report(const char* path, bool killed, int status, double wall_seconds, const rusage& usage) {
  std::FILE* file = std::fopen(path, "w");
  if (!file) return std::perror(path), false;
  std::fprintf(file,
               "{\"killed\": %s, \"exit\": %d, \"signal\": %d, \"wall_seconds\": %.6f, \"user_seconds\": %.6f, "
               "\"system_seconds\": %.6f, \"peak_bytes\": %lld}\n",
               killed ? "true" : "false", WIFEXITED(status) ? WEXITSTATUS(status) : -1,
               WIFSIGNALED(status) ? WTERMSIG(status) : 0, wall_seconds, seconds_of(usage.ru_utime),
               seconds_of(usage.ru_stime), 1024LL * usage.ru_maxrss);
  return std::fclose(file) == 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "usage: bench_launch LIMIT_SECONDS LIMIT_BYTES REPORT COMMAND [ARGUMENT ...]\n");
    return 2;
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const pid_t self = getpid();
  const rlim_t limit = std::strtoull(argv[2], nullptr, 10);
  fetch_memory(limit);
  const auto start = Clock::now();
  const pid_t child = fork();
  if (child < 0) return std::perror("fork"), 1;
  if (child == 0) become(argv + 4, limit, self);
  const bool killed = wait_or_kill(child, std::strtod(argv[1], nullptr));
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  const double wall_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return report(argv[3], killed, status, wall_seconds, usage) ? 0 : 1;
}
