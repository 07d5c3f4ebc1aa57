#include "cli/commands.h"
#include "cli/name_services.h"
#include "cli/run.h"

int main(int argc, char** argv) {
  using namespace meshgauge::cli;
  use_built_in_name_services();
  return run(argc, argv, [argv](CLI::App& app, int& exit_code) {
    add_measuring(app, exit_code);
    add_serving(app, exit_code, argv);
  });
}
