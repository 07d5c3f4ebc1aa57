#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "server/http_library.h"

namespace meshgauge::cli {
namespace {

struct Flags {
  std::string host = "127.0.0.1";
  int port = 8080;
};

int run(const Flags& flags) {
  httplib::Client client(flags.host, flags.port);
  client.set_connection_timeout(2);
  client.set_read_timeout(5);
  const auto response = client.Get("/healthz");
  if (response && response->status == 200) return kExitResult;
  const std::string what = response ? "status " + std::to_string(response->status) : to_string(response.error());
  std::fprintf(stderr, "meshgauge: %s:%d is not healthy: %s\n", flags.host.c_str(), flags.port, what.c_str());
  return kExitUnhealthy;
}

}  // namespace

void add_health(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("health", "Ask a running service whether it is alive: exit 0 or 1");
  const auto flags = std::make_shared<Flags>();
  command.add_option("--host", flags->host, "Its address")->envname("MESHGAUGE_HOST")->capture_default_str();
  command.add_option("--port", flags->port, "Its port")
      ->envname("MESHGAUGE_PORT")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  command.callback([flags, &exit_code] { exit_code = run(*flags); });
}

}  // namespace meshgauge::cli
