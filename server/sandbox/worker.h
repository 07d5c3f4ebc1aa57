// The worker's side of the sandbox: a process that reads one mesh file and ends.
#pragma once

#include <span>

#include "api/formats/format.h"
#include "server/sandbox/confine.h"

namespace meshgauge::server::sandbox {

// Exit codes of a worker. The first two say nothing about the file, which was not read.
inline constexpr int kNotConfined = 70;
inline constexpr int kNotAsked = 71;  // or by an invalid message
inline constexpr int kNotTaken = 72;  // the mesh could not be handed over

// How a worker reads the bytes: api::read_part, or a test's function.
using Read = Result<api::ReadMesh> (*)(std::span<const std::byte> bytes, const api::ReadHints& hints,
                                       const api::ReadLimits& limits);

// Confines this process, waits for one Request on kChannel, answers it, and ends. For a process that was just forked,
// with one thread and descriptors 0 to kChannel only. `parent`: the process that must outlive it.
[[noreturn]] void run_worker(Read read, const Bounds& bounds, const Rules& rules, int parent);

}  // namespace meshgauge::server::sandbox
