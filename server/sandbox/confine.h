// What a worker may still do, and how much of it: for a process that has one thread, and not to be undone.
#pragma once

#include <linux/filter.h>

#include <string>
#include <vector>

#include "server/sandbox/protocol.h"

namespace meshgauge::server::sandbox {

// The descriptors that a worker has, beside 0 to 2, which lead nowhere.
inline constexpr int kChannel = 3;
inline constexpr int kInput = 4;   // the file, read-only
inline constexpr int kWindow = 5;  // the shared memory for its arrays

// A sanitizer lives on calls and on address space that a worker must not have, so such builds leave out the filter and
// the limits of memory and of descriptors.
#ifdef MESHGAUGE_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

// The rights beyond those of its user, as root's: none are left, to this process and to those that it makes or becomes.
// False when it still has one.
bool drop_capabilities();

// No new privileges, no core file, not to be traced, dead when its parent dies; memory and processor time within
// `bounds`; no further descriptors or processes, nothing written to any file. False when the kernel refuses one of
// them. When the time is over it is SIGXCPU that ends the process, and not SIGKILL, which would be somebody else's.
bool limit_resources(const Bounds& bounds);

// The rules of forbid_calls(), in the kernel's form. Making them takes longer than all else that a worker does before
// it reads: the spawner makes them once.
struct Rules {
  std::vector<sock_filter> program;
  int error = 0;  // an errno: why there are none
};
Rules compile_rules();

// From here on any system call kills the process but: getting and returning private memory that cannot be executed,
// mapping kWindow, reading the clock, waking a thread, receiving and sending on kChannel, and ending.
// Gives 0 or the errno that says why it is not so.
int forbid_calls(const Rules& rules);

// Tries the last two in a process of its own, which then makes a forbidden call. For a process without threads that may
// wait for its children.
Trial try_confinement(const Bounds& bounds, const Rules& rules);

}  // namespace meshgauge::server::sandbox
