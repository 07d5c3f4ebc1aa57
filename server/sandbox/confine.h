// Confines a process: its system calls, memory and time. For a process with one thread; cannot be undone.
#pragma once

#include <linux/filter.h>

#include <vector>

#include "server/sandbox/protocol.h"

namespace meshgauge::server::sandbox {

// Descriptors of a worker, beside 0 to 2, which are /dev/null.
inline constexpr int kChannel = 3;
inline constexpr int kInput = 4;   // the mesh file, read-only
inline constexpr int kWindow = 5;  // shared memory for the arrays

// Sanitizers need calls and address space that a worker must not have, so these builds leave out the filter and the
// limits of memory and descriptors.
#ifdef MESHGAUGE_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

// Drops all capabilities of this process and of its children. False: one is left.
bool drop_capabilities();

// Sets no_new_privs, no core file, no tracing, death with the parent, limits of memory and processor time by
// `bounds`, no further descriptors or processes, no writing to files. False: the kernel refused one of them. The time
// limit ends the process by SIGXCPU, so that SIGKILL always comes from outside.
bool limit_resources(const Bounds& bounds);

// The filter of forbid_calls() in the kernel's form. Compiling it takes longer than everything else that a worker
// does before it reads, so the spawner compiles it once.
struct Rules {
  std::vector<sock_filter> program;
  int error = 0;  // errno of the failure; 0: none
};
Rules compile_rules();

// Kills the process at any system call except: allocating, advising on and freeing private non-executable memory,
// mapping kWindow, reading the clock, futexes, receiving and sending on kChannel, and exiting. Returns 0, or the errno
// of the failure.
int forbid_calls(const Rules& rules);

// Tries limit_resources() and forbid_calls() in a child that then makes a forbidden call. For a process without
// threads that may wait for its children.
Trial try_confinement(const Bounds& bounds, const Rules& rules);

}  // namespace meshgauge::server::sandbox
