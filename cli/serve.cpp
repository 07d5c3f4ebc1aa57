#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/formats/read_part.h"
#include "cli/commands.h"
#include "cli/setting_flags.h"
#include "server/main/checked.h"
#include "server/main/service.h"
#include "server/main/settings_file.h"
#include "server/main/worker.h"
#include "server/sandbox/become_reader.h"
#include "server/sandbox/reader/image.h"
#include "server/sandbox/spawner.h"

namespace meshgauge::cli {
namespace {

constexpr const char* kSandboxCommand = "sandbox";

using Serve = Result<Done> (*)(const server::Settings& settings, const std::vector<std::string>& parser);

int run(const Result<server::Settings>& asked, bool print, Serve serve) {
  if (!asked) return fail(asked.error());
  const auto settings = server::checked(*asked);
  if (!settings) return fail(settings.error());
  if (print) return std::printf("%s", to_text(*asked, *settings).c_str()) < 0 ? kExitError : kExitResult;
  const auto ended = serve(*settings, {"/proc/self/exe", kSandboxCommand});
  return ended ? kExitResult : fail(ended.error());
}

// Adds a subcommand that runs until it is told to end, with all settings of the service.
void add(CLI::App& app, int& exit_code, const char* name, const char* help, Serve serve) {
  CLI::App& command = *app.add_subcommand(name, help);
  const auto settings = add_settings(command);
  const auto print = std::make_shared<bool>(false);
  command.add_flag("--print-config", *print, "Print the settings in force, as a file for --config, and end");
  command.callback([settings, print, serve, &exit_code] { exit_code = run(settings(), *print, serve); });
}

}  // namespace

void add_serve(CLI::App& app, int& exit_code) {
  add(app, exit_code, "serve", "Run the service", server::run_until_signal);
}

void add_worker(CLI::App& app, int& exit_code) {
  add(app, exit_code, "worker", "Run what services on the same database have taken in",
      server::run_worker_until_signal);
}

void add_sandbox(CLI::App& app, int& exit_code, char** arguments) {
  CLI::App& command = *app.add_subcommand(kSandboxCommand, "Used by `serve`: makes the processes that read uploads");
  command.group("");  // not in the help
  command.callback([&exit_code, arguments] {
    const std::string why_not = server::sandbox::become_reader(server::sandbox::reader_image(), arguments);
    exit_code = server::sandbox::run_spawner(api::read_part, why_not);
  });
}

}  // namespace meshgauge::cli
