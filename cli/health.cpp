#include <cstdio>
#include <memory>
#include <string_view>

#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "cli/setting_flags.h"
#include "server/http/http_library.h"

namespace meshgauge::cli {
namespace {

// The certificate is not verified: nothing secret is sent, and the address is an IP and a port rather than a name.
httplib::Result ask(const server::Settings& settings, bool tls) {
  const std::string scheme = tls ? "https://" : "http://";
  const bool v6 = settings.host.find(':') != std::string::npos;
  httplib::Client client(scheme + (v6 ? "[" + settings.host + "]" : settings.host) + ":" +
                         std::to_string(settings.port));
  client.enable_server_certificate_verification(false);
  client.set_connection_timeout(2);
  client.set_read_timeout(5);
  return client.Get("/healthz");
}

int run(const Result<server::Settings>& settings, bool https) {
  if (!settings) return fail(settings.error());
  const auto response = ask(*settings, https || !settings->tls_certificate.empty());
  if (response && response->status == 200) return kExitResult;
  const std::string what = response ? "answers /healthz with status " + std::to_string(response->status)
                                    : "does not answer: check --host and --port";
  std::fprintf(stderr, "meshgauge: the service at %s:%d %s\n", settings->host.c_str(), static_cast<int>(settings->port),
               what.c_str());
  return kExitUnhealthy;
}

}  // namespace

void add_health(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("health", "Ask a running service whether it is alive: exit 0 or 1");
  const auto settings = add_settings(
      command, [](std::string_view name) { return name == "host" || name == "port" || name == "tls_certificate"; });
  const auto https = std::make_shared<bool>(false);
  command.add_flag("--https", *https, "Ask by TLS, as with --tls-certificate; the certificate is not checked");
  command.callback([settings, https, &exit_code] { exit_code = run(settings(), *https); });
}

}  // namespace meshgauge::cli
