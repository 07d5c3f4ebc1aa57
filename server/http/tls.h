// TLS 1.2 and 1.3 by OpenSSL for accepted connections, with a certificate and key that can be reloaded.
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
  // Names of PEM files: the certificate with its chain, and its key without a passphrase. Only reload() reads them.
  Tls(std::string certificate, std::string key);

  // Reads both files, for new connections. Returns the certificate's end of validity as text. An Error names the file;
  // the certificate and key that were loaded before stay in use.
  Result<std::string> reload();

  // Returns a transport for an accepted socket, which it borrows. Precondition: reload() has succeeded once. Throws:
  // out of memory.
  std::unique_ptr<Transport> accept(int fd) const;

 private:
  const std::string certificate_;
  const std::string key_;
  mutable std::mutex mutex_;
  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace meshgauge::server
