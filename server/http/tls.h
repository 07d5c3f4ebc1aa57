// TLS 1.2 and 1.3 by OpenSSL, for the connections of the service: a certificate and its key, read from files, and the
// sessions that show it.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "engine/result.h"
#include "server/http/transport.h"

struct ssl_ctx_st;  // OpenSSL's SSL_CTX

namespace meshgauge::server {

// Thread safe.
class Tls {
 public:
  // PEM files: the certificate with its chain, and the key without a passphrase. reload() reads them.
  Tls(std::string certificate, std::string key);

  // Reads both files anew, for the connections that come. After an Error, which names the file, those that came before
  // are used on. Returns until when the certificate is valid, for people.
  Result<std::string> reload();

  // What an accepted socket speaks. Precondition: reload() was successful once. Throws: out of memory.
  std::unique_ptr<Transport> accept(int fd) const;

 private:
  const std::string certificate_;
  const std::string key_;
  mutable std::mutex mutex_;
  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace meshgauge::server
