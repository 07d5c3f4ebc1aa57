#include "server/sandbox/confine.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <vector>

#include <linux/capability.h>
#include <linux/seccomp.h>
#include <seccomp.h>

#include "api/base/descriptor.h"

namespace meshgauge::server::sandbox {
namespace {

// Address space of the program and its libraries. Generous, since the limit is for shared memory, which RLIMIT_DATA
// does not count.
constexpr std::uint64_t kProgramBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMost = std::uint64_t{1} << 60;  // sums must not overflow
constexpr std::uint64_t kStackBytes = std::uint64_t{8} << 20;

// Exit codes of the probe, beside an errno of the filter.
constexpr int kUnlimited = 254;    // a limit was refused
constexpr int kWentThrough = 255;  // a forbidden call succeeded

template <class Resource>
bool limit(Resource resource, std::uint64_t soft, std::uint64_t hard) {
  rlimit now{};
  if (::getrlimit(resource, &now) != 0) return false;
  const rlimit both{std::min<rlim_t>(soft, now.rlim_max), std::min<rlim_t>(hard, now.rlim_max)};
  return ::setrlimit(resource, &both) == 0;
}

template <class Resource>
bool limit(Resource resource, std::uint64_t most) {
  return limit(resource, most, most);
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
    set(SCMP_FLTATR_API_SYSRAWRC, 1);  // otherwise every refusal of the kernel becomes ECANCELED
  }

  void allow(int call, std::initializer_list<scmp_arg_cmp> conditions = {}) {
    if (error_ != 0) return;
    const std::vector<scmp_arg_cmp> all(conditions);
    error_ =
        seccomp_rule_add_array(context_.get(), SCMP_ACT_ALLOW, call, static_cast<unsigned>(all.size()), all.data());
  }

  // Returns 0, or the errno of the failure.
  int compile(std::vector<sock_filter>& program) {
    const Descriptor file(::memfd_create("filter", MFD_CLOEXEC));
    if (error_ == 0 && !file) error_ = -errno;
    if (error_ == 0) error_ = seccomp_export_bpf(context_.get(), file.get());
    if (error_ != 0) return -error_;
    const off_t bytes = ::lseek(file.get(), 0, SEEK_END);
    program.resize(bytes > 0 ? static_cast<std::size_t>(bytes) / sizeof(sock_filter) : 0);
    const std::size_t size = program.size() * sizeof(sock_filter);
    const ssize_t got = ::pread(file.get(), program.data(), size, 0);
    return got > 0 && static_cast<std::size_t>(got) == size ? 0 : EIO;
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

// Interprets the wait status of the probe.
Trial judge(int status) {
  if (WIFSIGNALED(status)) {
    if (WTERMSIG(status) == SIGSYS) return {};
    return {"a trial was ended by signal " + std::to_string(WTERMSIG(status)), "", ""};
  }
  if (WEXITSTATUS(status) == kUnlimited) return {"the limits of a process cannot be set", "", ""};
  if (kSanitized) return {"", "a build with sanitizers leaves it out", ""};
  if (WEXITSTATUS(status) == kWentThrough) return {"", "a call that it forbids went through", ""};
  return {"", std::strerror(WEXITSTATUS(status)), ""};
}

}  // namespace

bool drop_capabilities() {
  // Reducing the bounding set needs a capability; without it the set is harmless.
  for (unsigned long capability = 0; ::prctl(PR_CAPBSET_READ, capability) >= 0; ++capability) {
    ::prctl(PR_CAPBSET_DROP, capability);
  }
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3] = {};
  ::syscall(SYS_capset, &header, sets);  // also clears the ambient set
  return ::syscall(SYS_capget, &header, sets) == 0 &&
         std::ranges::all_of(sets, [](const auto& set) { return (set.permitted | set.inheritable) == 0; });
}

bool limit_resources(const Bounds& bounds) {
  return ::prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_DUMPABLE, 0) == 0 && limit(RLIMIT_CORE, 0) &&
         limit(RLIMIT_CPU, bounds.cpu_seconds, bounds.cpu_seconds + 1) &&
         (kSanitized || (limit_memory(bounds) && limit(RLIMIT_FSIZE, 0) && limit(RLIMIT_NOFILE, kWindow + 1) &&
                         limit(RLIMIT_NPROC, 0)));
}

Rules compile_rules() {
  Rules rules;
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
  rules.error = filter.compile(rules.program);
  return rules;
}

int forbid_calls(const Rules& rules) {
  if (kSanitized) return ENOTSUP;
  if (rules.error != 0) return rules.error;
  const sock_fprog program{static_cast<unsigned short>(rules.program.size()),
                           const_cast<sock_filter*>(rules.program.data())};  // the kernel only reads it
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0 ? 0 : errno;
}

Trial try_confinement(const Bounds& bounds, const Rules& rules) {
  const pid_t probe = ::fork();
  if (probe < 0) return {std::string("no process can be made: ") + std::strerror(errno), "", ""};
  if (probe == 0) {
    if (!limit_resources(bounds)) ::_exit(kUnlimited);
    const int refused = forbid_calls(rules);
    if (refused != 0) ::_exit(refused);
    [[maybe_unused]] const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    ::_exit(kWentThrough);
  }
  int status = 0;
  if (::waitpid(probe, &status, 0) != probe) return {std::string("a trial was lost: ") + std::strerror(errno), "", ""};
  return judge(status);
}

}  // namespace meshgauge::server::sandbox
