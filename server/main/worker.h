// `meshgauge worker`: a process that runs the jobs of shared stores.
#pragma once

#include <string>
#include <vector>

#include "engine/result.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// Runs until SIGTERM, SIGINT or the SIGHUP of a closed terminal. Then it stops claiming and hands back jobs that have
// not begun; running jobs may end within `grace_ms`, or until a second signal, and are then handed back with the
// interval reached. An Error: it could not start. Blocks these signals in the calling thread and the threads that it
// starts. `parser` as for run_until_signal(). Precondition: settings come from checked().
Result<Done> run_worker_until_signal(const Settings& settings, const std::vector<std::string>& parser);

}  // namespace meshgauge::server
