#include "net/http_client.h"

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge::net;

TEST_CASE("http client: a peer that closes while it is written to does not end the process") {
  REQUIRE((std::signal(SIGPIPE, SIG_DFL) != SIG_ERR));
  const HttpClient client(HttpSettings{});
  CHECK((std::signal(SIGPIPE, SIG_DFL) == SIG_IGN));
}

TEST_CASE("certificates are those of SSL_CERT_FILE, else those of the distribution") {
  const char* before = std::getenv("SSL_CERT_FILE");
  const std::string kept = before ? before : "";
  ::setenv("SSL_CERT_FILE", "/of/this/test.pem", 1);
  CHECK(machine_certificates() == "/of/this/test.pem");
  ::setenv("SSL_CERT_FILE", "", 1);
  const std::string found = machine_certificates();
  CHECK((found.empty() || std::filesystem::exists(found)));
  CHECK(found.empty() == !(std::filesystem::exists("/etc/ssl/certs/ca-certificates.crt") ||
                           std::filesystem::exists("/etc/pki/tls/certs/ca-bundle.crt") ||
                           std::filesystem::exists("/etc/ssl/ca-bundle.pem") ||
                           std::filesystem::exists("/etc/ssl/cert.pem")));
  if (before) {
    ::setenv("SSL_CERT_FILE", kept.c_str(), 1);
  } else {
    ::unsetenv("SSL_CERT_FILE");
  }
}
