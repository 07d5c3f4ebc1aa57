// A service alone, without what measures on the command line: ./dev run has it ready before the whole program.
#include "cli/commands.h"
#include "cli/run.h"

int main(int argc, char** argv) {
  using namespace meshgauge::cli;
  return run(argc, argv, [argv](CLI::App& app, int& exit_code) { add_serving(app, exit_code, argv); });
}
