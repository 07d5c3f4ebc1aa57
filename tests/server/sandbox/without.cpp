// Runs a program as on a machine that lacks something: without seccomp|seals|limits|programs PROGRAM [ARGUMENT ...]
// "programs" are those in memory: such a machine executes files alone.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include <linux/prctl.h>
#include <seccomp.h>

namespace {

// Calls whose argument number `argument` is `value` fail with `error`.
bool take_away(scmp_filter_ctx filter, int call, unsigned argument, int value, std::uint16_t error) {
  const scmp_arg_cmp condition{argument, SCMP_CMP_EQ, static_cast<scmp_datum_t>(value), 0};
  return seccomp_rule_add_array(filter, SCMP_ACT_ERRNO(error), call, 1, &condition) == 0;
}

bool take_away(scmp_filter_ctx filter, std::string_view what) {
  if (what == "seals") return take_away(filter, SCMP_SYS(fcntl), 1, F_ADD_SEALS, EINVAL);
  if (what == "programs") return seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), SCMP_SYS(execveat), 0) == 0;
  if (what == "limits") return take_away(filter, SCMP_SYS(prlimit64), 1, RLIMIT_CPU, EPERM);
  return what == "seccomp" && seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(seccomp), 0) == 0 &&
         take_away(filter, SCMP_SYS(prctl), 0, PR_SET_SECCOMP, EINVAL);
}

}  // namespace

int main(int argc, char** argv) {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
  if (argc < 3 || filter == nullptr || !take_away(filter, argv[1]) || seccomp_load(filter) != 0) {
    std::fputs("usage: without seccomp|seals|limits|programs PROGRAM [ARGUMENT ...]\n", stderr);
    return 2;
  }
  ::execvp(argv[2], argv + 2);
  std::perror(argv[2]);
  return 2;
}
