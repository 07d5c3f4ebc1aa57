#include <CLI/CLI.hpp>

#include "api/formats/read_part.h"
#include "cli/commands.h"
#include "server/sandbox/become_reader.h"
#include "server/sandbox/reader/image.h"
#include "server/sandbox/spawner.h"

namespace meshgauge::cli {

void add_sandbox(CLI::App& app, int& exit_code, char** arguments) {
  CLI::App& command = *app.add_subcommand(kSandboxCommand, "Used by `serve`: makes the processes that read uploads");
  command.group("");  // not in the help
  command.callback([&exit_code, arguments] {
    const std::string why_not = server::sandbox::become_reader(server::sandbox::reader_image(), arguments);
    exit_code = server::sandbox::run_spawner(api::read_part, why_not);
  });
}

}  // namespace meshgauge::cli
