#include "api/base/digest.h"

#include <array>
#include <new>
#include <stdexcept>

#include <openssl/evp.h>
#include <openssl/rand.h>

namespace meshgauge::api {
namespace {

// OpenSSL fails where memory is missing: waits for it, or throws, as operator new does.
template <class Call>
void until_it_succeeds(Call call) {
  while (!call()) {
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
  }
}

}  // namespace

std::string to_hex(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  out.reserve(2 * bytes.size());
  for (const std::byte byte : bytes) {
    out += kDigits[std::to_integer<unsigned>(byte >> 4)];
    out += kDigits[std::to_integer<unsigned>(byte & std::byte{15})];
  }
  return out;
}

void Sha256::Freed::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Sha256::Sha256() {
  until_it_succeeds([this] {
    context_.reset(EVP_MD_CTX_new());
    return context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1;
  });
}

void Sha256::update(std::span<const std::byte> piece) {
  if (EVP_DigestUpdate(context_.get(), piece.data(), piece.size()) != 1) throw std::runtime_error("SHA-256 failed");
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_DigestFinal_ex(context_.get(), digest.data(), &size) != 1) throw std::runtime_error("SHA-256 failed");
  return to_hex(std::as_bytes(std::span(digest).first(size)));
}

std::string sha256_hex(std::span<const std::byte> bytes) {
  Sha256 sha256;
  sha256.update(bytes);
  return sha256.hex();
}

std::string random_id() {
  constexpr std::size_t kBytes = 16;
  thread_local std::array<unsigned char, kBytes * 64> drawn{};  // a draw costs as much as many ids
  thread_local std::size_t used = drawn.size();
  if (used == drawn.size()) {
    until_it_succeeds([] { return RAND_bytes(drawn.data(), static_cast<int>(drawn.size())) == 1; });
    used = 0;
  }
  used += kBytes;
  return to_hex(std::as_bytes(std::span(drawn).subspan(used - kBytes, kBytes)));
}

void set_up_digests() {
  sha256_hex({});
  random_id();
}

}  // namespace meshgauge::api
