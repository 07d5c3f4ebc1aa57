#include "cli/commands.h"
#include "cli/name_services.h"
#include "cli/run.h"

int main(int argc, char** argv) {
  using namespace meshgauge::cli;
  use_built_in_name_services();
  return run(argc, argv, [argv](CLI::App& app, int& exit_code) {
    add_serve(app, exit_code);
    add_worker(app, exit_code);
    add_migrate(app, exit_code);
    add_health(app, exit_code);
    add_keys(app, exit_code);
    add_sandbox(app, exit_code, argv);
  });
}
