#include <unistd.h>

#include <cstdio>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/formats/read_part.h"
#include "cli/commands.h"
#include "cli/setting_flags.h"
#include "server/base/heap.h"
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

constexpr std::string_view kNoMemory =
    "no memory is left to start with: raise its limit (ulimit -v, that of the container), or lower --workers, "
    "--io-threads and --parsers";

// Threads of the service may wait for memory, and others for them, so no exception would end the start.
void end_without_memory() {
  for (const std::string_view text : {std::string_view("meshgauge: "), kNoMemory, std::string_view("\n")}) {
    if (::write(STDERR_FILENO, text.data(), text.size()) < 0) break;
  }
  ::_exit(kExitError);
}

// What the system does not grant a service that starts is an Error that says what to do.
Result<Done> started(Serve serve, const server::Settings& settings) try {
  server::end_start_without_memory(end_without_memory);
  return serve(settings, {"/proc/self/exe", kSandboxCommand});
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::internal, std::string(kNoMemory), "", ""};
} catch (const std::system_error& error) {
  if (error.code() != std::errc::resource_unavailable_try_again) throw;
  return Error{ErrorCode::internal,
               "the system grants no further thread: raise the limit on threads (ulimit -u, pids.max) or on memory "
               "(ulimit -v), or lower --io-threads and --workers",
               "", ""};
}

int run(const Result<server::Settings>& asked, bool print, Serve serve) {
  if (!asked) return fail(asked.error());
  const auto settings = server::checked(*asked);
  if (!settings) return fail(settings.error());
  if (print) return std::printf("%s", to_text(*asked, *settings).c_str()) < 0 ? kExitError : kExitResult;
  const auto ended = started(serve, *settings);
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
