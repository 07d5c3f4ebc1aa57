// `meshgauge worker`: a process that runs the jobs of stores that it shares with others.
#pragma once

#include <string>
#include <vector>

#include "engine/result.h"
#include "server/settings.h"

namespace meshgauge::server {

// Works until SIGTERM or SIGINT, or until its terminal is closed. Then it claims nothing more and hands back what it
// has not begun; what runs may end within `grace_ms`, or until a second signal, and then goes back with the interval
// that it has reached. An Error when it could not start. Blocks these signals in the calling thread and those it
// starts. `parser` as for run_until_signal(). Precondition: settings come from checked().
Result<Done> run_worker_until_signal(const Settings& settings, const std::vector<std::string>& parser);

}  // namespace meshgauge::server
