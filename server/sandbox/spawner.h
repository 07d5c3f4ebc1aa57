// The process that forks the workers. The server executes its own program anew for it (spawner_client.h), so that it
// shares no memory with the server and has another layout of addresses. It has one thread, so it may fork.
//
// It never sees a byte of a file. It ends, with its workers, when the server closes its end of the control channel or
// dies; it kills a worker when the server closes that worker's second channel.
#pragma once

#include <string>

#include "server/sandbox/worker.h"

namespace meshgauge::server::sandbox {

inline constexpr int kControl = 3;  // channel of the spawner's orders

// Runs the spawner: drops capabilities, receives Bounds on kControl, answers with its Trial of them, then forks a
// worker for each message. Returns the exit code: 0, or 3 if kControl is not a channel, as when a user starts it.
// `small`: why this is not the small program, for the Trial.
int run_spawner(Read read, const std::string& small = "");

}  // namespace meshgauge::server::sandbox
