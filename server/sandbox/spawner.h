// The process that makes the workers. The server starts it by executing its own program anew (spawner_client.h), so it
// and its workers have nothing of the server's memory and another layout of addresses; and it has one thread, so it may
// fork.
//
// It never sees a byte of a file. It ends when the server closes its end of the control channel or dies, and its
// workers with it; a worker is killed when the server closes that worker's second channel.
#pragma once

#include <string>

#include "server/sandbox/worker.h"

namespace meshgauge::server::sandbox {

inline constexpr int kControl = 3;  // the channel on which a spawner is told what to fork

// Gives up its capabilities, is told Bounds on kControl and answers with its Trial of them, then forks a worker for
// every message. Gives the exit code of the process: 0, or 3 when kControl is no channel, that is when a person started
// it. `small` goes into the Trial: why this is not the small program.
int run_spawner(Read read, const std::string& small = "");

}  // namespace meshgauge::server::sandbox
