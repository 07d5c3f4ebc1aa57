// The two uses of OpenSSL: names for bytes, and names nobody can guess.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

struct evp_md_ctx_st;  // OpenSSL's EVP_MD_CTX

namespace meshgauge::api {

std::string sha256_hex(std::span<const std::byte> bytes);  // 64 lower-case hex digits

// The same of bytes that are looked at piece by piece. Throws when the library has no SHA-256.
class Sha256 {
 public:
  Sha256();
  void update(std::span<const std::byte> piece);
  std::string hex();  // of all pieces; the last call

 private:
  struct Freed {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Freed> context_;
};

std::string random_id();  // 128 bits from the system's generator, 32 lower-case hex digits; throws when it fails

}  // namespace meshgauge::api
