// The child's side of the sandbox: a process that reads one mesh file and ends.
#pragma once

#include <span>

#include "api/formats/format.h"
#include "server/sandbox/confine.h"

namespace meshgauge::server::sandbox {

// Exit codes, as the server sees them. One of the first two says nothing about the file, which was not looked at.
inline constexpr int kNotConfined = 70;
inline constexpr int kNotAsked = 71;  // or not in words that have a meaning
inline constexpr int kNotTaken = 72;  // the mesh could not be handed over

// What a worker does with the bytes: api::read_part, or what a test puts in its place.
using Read = Result<api::ReadMesh> (*)(std::span<const std::byte> bytes, const api::ReadHints& hints,
                                       const api::ReadLimits& limits);

// Confines this process, waits for its one Request on kChannel, answers it, and ends. For a process that just forked,
// has one thread and no other descriptors than 0 to kChannel; `parent` is the process that must outlive it.
[[noreturn]] void run_worker(Read read, const Bounds& bounds, const Rules& rules, int parent);

}  // namespace meshgauge::server::sandbox
