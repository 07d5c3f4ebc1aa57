#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "engine/hausdorff.h"

namespace {

int run(int argc, char** argv) {
  CLI::App app{"Certified Hausdorff distance between triangle meshes", "meshgauge"};
  app.set_version_flag("--version", std::string("meshgauge ") + meshgauge::version());
  app.require_subcommand(1);
  int exit_code = meshgauge::cli::kExitError;
  meshgauge::cli::add_compare(app, exit_code);
  meshgauge::cli::add_check(app, exit_code);
  meshgauge::cli::add_serve(app, exit_code);
  meshgauge::cli::add_worker(app, exit_code);
  meshgauge::cli::add_migrate(app, exit_code);
  meshgauge::cli::add_health(app, exit_code);
  meshgauge::cli::add_keys(app, exit_code);
  meshgauge::cli::add_sandbox(app, exit_code, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : meshgauge::cli::kExitError;  // --help and --version are "errors" of code 0
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "meshgauge: %s\n", error.what());
    return meshgauge::cli::kExitError;
  }
}
