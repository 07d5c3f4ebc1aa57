// Runs a command line.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace meshgauge::cli {

// Runs the subcommand that the arguments name: one that needs no service, or one that `add_more` declares. Returns the
// exit code. Does not throw.
int run(int argc, char** argv, const std::function<void(CLI::App&, int&)>& add_more);

}  // namespace meshgauge::cli
