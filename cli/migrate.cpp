#include <cstdio>

#include <CLI/CLI.hpp>

#include "api/base/refused.h"
#include "cli/commands.h"
#include "cli/setting_flags.h"
#include "server/main/checked.h"
#include "server/store/forms/stores.h"

namespace meshgauge::cli {
namespace {

int run(const Result<server::Settings>& asked) {
  if (!asked) return fail(asked.error());
  const auto settings = server::checked(*asked);
  if (!settings) return fail(settings.error());
  if (!is_distributed(*settings))
    return fail(refused("--database is missing: give the connection string of a PostgreSQL (MESHGAUGE_DATABASE)"));
  const auto done = server::store::migrate_database(settings->database);
  if (!done) return fail(done.error());
  return std::printf("%s\n", to_string(*done).c_str()) < 0 ? kExitError : kExitResult;
}

}  // namespace

void add_migrate(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("migrate", "Bring a database to the schema of this version, and end");
  const auto settings = add_settings(command, [](std::string_view name) { return name == "database"; });
  command.callback([settings, &exit_code] { exit_code = run(settings()); });
}

}  // namespace meshgauge::cli
