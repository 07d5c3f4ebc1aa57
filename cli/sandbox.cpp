#include "api/load.h"
#include "cli/commands.h"
#include "server/sandbox/spawner.h"

namespace meshgauge::cli {

void add_sandbox(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand(kSandboxCommand, "Used by `serve`: makes the processes that read uploads");
  command.group("");  // not in the help
  command.callback([&exit_code] { exit_code = server::sandbox::run_spawner(api::read_part); });
}

}  // namespace meshgauge::cli
