// SHA-256 digests and random ids, by OpenSSL.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

struct evp_md_ctx_st;  // OpenSSL's EVP_MD_CTX

namespace meshgauge::api {

std::string to_hex(std::span<const std::byte> bytes);      // two lower-case hex digits for each
std::string sha256_hex(std::span<const std::byte> bytes);  // 64 lower-case hex digits

// Computes SHA-256 over pieces of data. The constructor throws std::bad_alloc when OpenSSL provides none.
class Sha256 {
 public:
  Sha256();
  void update(std::span<const std::byte> piece);
  std::string hex();  // 64 lower-case hex digits; no call may follow

 private:
  struct Freed {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Freed> context_;
};

// 128 random bits as 32 lower-case hex digits; throws std::bad_alloc when OpenSSL has none. They are drawn ahead:
// not for a child of fork().
std::string random_id();

// OpenSSL sets itself up at its first use, and never again where memory was missing then: call this at the start.
void set_up_digests();

}  // namespace meshgauge::api
