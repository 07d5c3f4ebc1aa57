// Runs a command line.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace meshgauge::cli {

// Runs the subcommand that the arguments name, one of those that `add` declares. Returns the exit code. Does not throw.
int run(int argc, char** argv, const std::function<void(CLI::App&, int&)>& add);

}  // namespace meshgauge::cli
