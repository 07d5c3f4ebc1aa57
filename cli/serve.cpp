#include <algorithm>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "server/service.h"
#include "server/settings.h"

namespace meshgauge::cli {
namespace {

int fail(const Error& error) {
  std::fprintf(stderr, "meshgauge: %s\n", error.message.c_str());
  return kExitError;
}

int run(const server::Settings& asked) {
  const auto settings = server::checked(asked);
  if (!settings) return fail(settings.error());
  const auto ended = server::run_until_signal(*settings, {"/proc/self/exe", kSandboxCommand});
  return ended ? kExitResult : fail(ended.error());
}

std::string flag_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name;
}

std::string variable_of(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return "MESHGAUGE_" + name;
}

}  // namespace

void add_serve(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("serve", "Run the service");
  const auto settings = std::make_shared<server::Settings>();
  server::for_each_setting(*settings, [&](const server::SettingText& text, auto& field) {
    command.add_option(flag_of(text.name), field, text.help)->envname(variable_of(text.name))->capture_default_str();
  });
  command.callback([settings, &exit_code] { exit_code = run(*settings); });
}

}  // namespace meshgauge::cli
