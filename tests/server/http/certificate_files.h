// A certificate of TLS for a test.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <doctest/doctest.h>

#include "api/base/digest.h"

namespace meshgauge::server {

// Files of a certificate for "localhost" and of its key.
class CertificateFiles {
 public:
  explicit CertificateFiles(const char* curve = "P-256")
      : path_(std::filesystem::temp_directory_path() / ("meshgauge-tls-" + api::random_id())) {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", curve),
                                                                  EVP_PKEY_free);
    const std::unique_ptr<X509, decltype(&X509_free)> certificate(X509_new(), X509_free);
    const bool made = key && certificate && fill(certificate.get(), key.get());
    REQUIRE(made);
    write(certificate_file(), [&](std::FILE* file) { return PEM_write_X509(file, certificate.get()); });
    write(key_file(), [&](std::FILE* file) {
      return PEM_write_PrivateKey(file, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
    });
  }
  ~CertificateFiles() {
    std::error_code ignored;
    std::filesystem::remove(certificate_file(), ignored);
    std::filesystem::remove(key_file(), ignored);
  }
  CertificateFiles(const CertificateFiles&) = delete;
  CertificateFiles& operator=(const CertificateFiles&) = delete;

  std::string certificate_file() const { return path_.string() + ".pem"; }
  std::string key_file() const { return path_.string() + ".key"; }

 private:
  static bool fill(X509* certificate, EVP_PKEY* key) {
    const unsigned char host[] = "localhost";
    X509_NAME* const name = X509_get_subject_name(certificate);
    return ASN1_INTEGER_set(X509_get_serialNumber(certificate), 1) == 1 &&
           X509_gmtime_adj(X509_getm_notBefore(certificate), -3600) != nullptr &&
           X509_gmtime_adj(X509_getm_notAfter(certificate), 3600) != nullptr &&
           X509_set_pubkey(certificate, key) == 1 &&
           X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, host, -1, -1, 0) == 1 &&
           X509_set_issuer_name(certificate, name) == 1 && X509_sign(certificate, key, EVP_sha256()) > 0;
  }

  template <class Write>
  static void write(const std::string& name, const Write& contents) {
    std::FILE* const file = std::fopen(name.c_str(), "w");
    const bool open = file != nullptr;
    REQUIRE(open);
    const bool written = contents(file) == 1;
    REQUIRE(std::fclose(file) == 0);
    REQUIRE(written);
  }

  const std::filesystem::path path_;
};

}  // namespace meshgauge::server
