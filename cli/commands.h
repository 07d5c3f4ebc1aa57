// Subcommands. Each function declares the flags of one; its callback runs it and stores the exit code.
#pragma once

#include <cstdio>

#include "engine/result.h"

namespace CLI {
class App;
}

namespace meshgauge::cli {

inline constexpr int kExitResult = 0;
inline constexpr int kExitFail = 1, kExitUndecided = 2;  // of a comparison with limits or expectations
inline constexpr int kExitUnhealthy = 1;
inline constexpr int kExitError = 3;  // bad flags, unreadable input, or a failure

// Prints the messages on standard error. Returns the exit code for them.
inline int fail(const Error& error) {
  std::fprintf(stderr, "meshgauge: %s\n", error.message.c_str());
  for (const Error& other : error.others) std::fprintf(stderr, "meshgauge: %s\n", other.message.c_str());
  return kExitError;
}

void add_check(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_health(CLI::App& app, int& exit_code);
void add_keys(CLI::App& app, int& exit_code);
void add_mcp(CLI::App& app, int& exit_code);
void add_migrate(CLI::App& app, int& exit_code);
void add_sandbox(CLI::App& app, int& exit_code, char** arguments);
void add_serve(CLI::App& app, int& exit_code);
void add_worker(CLI::App& app, int& exit_code);

// Those that need no service: compare, check and mcp.
inline void add_measuring(CLI::App& app, int& exit_code) {
  add_compare(app, exit_code);
  add_check(app, exit_code);
  add_mcp(app, exit_code);
}
// Those of a service. `arguments` are those of the process.
inline void add_serving(CLI::App& app, int& exit_code, char** arguments) {
  add_serve(app, exit_code);
  add_worker(app, exit_code);
  add_migrate(app, exit_code);
  add_health(app, exit_code);
  add_keys(app, exit_code);
  add_sandbox(app, exit_code, arguments);
}

}  // namespace meshgauge::cli
