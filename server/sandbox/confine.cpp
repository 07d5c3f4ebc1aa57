#include "server/sandbox/confine.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <vector>

#include <seccomp.h>

namespace meshgauge::server::sandbox {
namespace {

// The program and its libraries; generous, since what it is for is shared memory, which RLIMIT_DATA does not count.
constexpr std::uint64_t kProgramBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMost = std::uint64_t{1} << 60;  // so that no sum overflows
constexpr std::uint64_t kStackBytes = std::uint64_t{8} << 20;
constexpr int kWentThrough = 255;  // the probe's exit code for a forbidden call that was carried out

template <class Resource>
bool limit(Resource resource, std::uint64_t most) {
  rlimit now{};
  if (::getrlimit(resource, &now) != 0) return false;
  const rlim_t value = std::min<rlim_t>(most, now.rlim_max);
  const rlimit both{value, value};
  return ::setrlimit(resource, &both) == 0;
}

bool limit_memory(const Bounds& bounds) {
  return limit(RLIMIT_DATA, bounds.memory_bytes) &&
         limit(RLIMIT_AS, std::min(bounds.memory_bytes, kMost) + std::min(bounds.input_bytes, kMost) + kProgramBytes) &&
         limit(RLIMIT_STACK, kStackBytes) && limit(RLIMIT_MEMLOCK, 0);
}

class Filter {
 public:
  Filter() : context_(seccomp_init(SCMP_ACT_KILL_PROCESS)) {
    if (!context_) error_ = -ENOMEM;
    set(SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
    set(SCMP_FLTATR_API_SYSRAWRC, 1);  // or every refusal of the kernel is told as ECANCELED
  }

  void allow(int call, std::initializer_list<scmp_arg_cmp> conditions = {}) {
    if (error_ != 0) return;
    const std::vector<scmp_arg_cmp> all(conditions);
    error_ =
        seccomp_rule_add_array(context_.get(), SCMP_ACT_ALLOW, call, static_cast<unsigned>(all.size()), all.data());
  }

  int load() {
    if (error_ == 0) error_ = seccomp_load(context_.get());
    return -error_;
  }

 private:
  void set(scmp_filter_attr attribute, std::uint32_t value) {
    if (error_ == 0) error_ = seccomp_attr_set(context_.get(), attribute, value);
  }

  struct Released {
    void operator()(void* context) const { seccomp_release(context); }
  };
  std::unique_ptr<void, Released> context_;
  int error_ = 0;
};

scmp_arg_cmp equal(unsigned argument, int value) {
  return {argument, SCMP_CMP_EQ, static_cast<scmp_datum_t>(value), 0};
}

scmp_arg_cmp masked(unsigned argument, int mask, int value) {
  return {argument, SCMP_CMP_MASKED_EQ, static_cast<scmp_datum_t>(mask), static_cast<scmp_datum_t>(value)};
}

}  // namespace

bool limit_resources(const Bounds& bounds) {
  return ::prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_DUMPABLE, 0) == 0 && limit(RLIMIT_CORE, 0) && limit(RLIMIT_CPU, bounds.cpu_seconds) &&
         (kSanitized || (limit_memory(bounds) && limit(RLIMIT_FSIZE, 0) && limit(RLIMIT_NOFILE, kWindow + 1) &&
                         limit(RLIMIT_NPROC, 0)));
}

int forbid_calls() {
  if (kSanitized) return ENOTSUP;
  Filter filter;
  for (const int call : {SCMP_SYS(brk), SCMP_SYS(munmap), SCMP_SYS(mremap), SCMP_SYS(futex), SCMP_SYS(clock_gettime),
                         SCMP_SYS(exit), SCMP_SYS(exit_group)}) {
    filter.allow(call);
  }
  filter.allow(SCMP_SYS(mmap), {masked(2, PROT_EXEC, 0), masked(3, MAP_TYPE, MAP_PRIVATE)});
  filter.allow(SCMP_SYS(mmap), {masked(2, PROT_EXEC, 0), masked(3, MAP_TYPE, MAP_SHARED), equal(4, kWindow)});
  for (const int advice : {MADV_HUGEPAGE, MADV_DONTNEED}) filter.allow(SCMP_SYS(madvise), {equal(2, advice)});
  filter.allow(SCMP_SYS(recvmsg), {equal(0, kChannel)});
  filter.allow(SCMP_SYS(sendmsg), {equal(0, kChannel)});
  return filter.load();
}

std::string why_calls_are_not_forbidden() {
  if (kSanitized) return "a build with sanitizers leaves it out";
  const pid_t probe = ::fork();
  if (probe < 0) return std::string("no process to try it in: ") + std::strerror(errno);
  if (probe == 0) {
    const int refused = forbid_calls();
    if (refused != 0) ::_exit(refused);
    [[maybe_unused]] const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    ::_exit(kWentThrough);
  }
  int status = 0;
  if (::waitpid(probe, &status, 0) != probe) return std::string("its trial was lost: ") + std::strerror(errno);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS) return "";
  if (WIFEXITED(status) && WEXITSTATUS(status) != kWentThrough) return std::strerror(WEXITSTATUS(status));
  return "a call that it forbids went through";
}

}  // namespace meshgauge::server::sandbox
