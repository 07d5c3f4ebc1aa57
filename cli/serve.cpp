#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "cli/setting_flags.h"
#include "server/service.h"
#include "server/settings_file.h"

namespace meshgauge::cli {
namespace {

int fail(const Error& error) {
  std::fprintf(stderr, "meshgauge: %s\n", error.message.c_str());
  return kExitError;
}

int run(const Result<server::Settings>& asked, bool print) {
  if (!asked) return fail(asked.error());
  const auto settings = server::checked(*asked);
  if (!settings) return fail(settings.error());
  if (print) return std::printf("%s", to_text(*asked, *settings).c_str()) < 0 ? kExitError : kExitResult;
  const auto ended = server::run_until_signal(*settings, {"/proc/self/exe", kSandboxCommand});
  return ended ? kExitResult : fail(ended.error());
}

}  // namespace

void add_serve(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("serve", "Run the service");
  const auto settings = add_settings(command);
  const auto print = std::make_shared<bool>(false);
  command.add_flag("--print-config", *print, "Print the settings in force, as a file for --config, and end");
  command.callback([settings, print, &exit_code] { exit_code = run(settings(), *print); });
}

}  // namespace meshgauge::cli
