#include "net/certificates.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace meshgauge::net {
namespace {

constexpr const char* kPlaces[] = {
    "/etc/ssl/certs/ca-certificates.crt",  // Debian, Ubuntu, Arch, Alpine
    "/etc/pki/tls/certs/ca-bundle.crt",    // Fedora, Red Hat
    "/etc/ssl/ca-bundle.pem",              // openSUSE
    "/etc/ssl/cert.pem",                   // others
};

}  // namespace

std::string machine_certificates() {
  const char* named = std::getenv("SSL_CERT_FILE");
  if (named && *named != '\0') return named;
  for (const char* place : kPlaces) {
    std::error_code ignored;
    if (std::filesystem::exists(place, ignored)) return place;
  }
  return "";
}

}  // namespace meshgauge::net
