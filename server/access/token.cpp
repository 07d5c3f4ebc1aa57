#include "server/access/token.h"

#include <algorithm>
#include <span>

#include <openssl/crypto.h>

#include "api/digest.h"
#include "api/refused.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

bool is_token68_char(char c) {
  return is_digit(c) || (lower(c) >= 'a' && lower(c) <= 'z') ||
         std::string_view("-._~+/=").find(c) != std::string::npos;
}

}  // namespace

std::string new_token() { return "mg_" + api::random_id() + api::random_id(); }

Result<Done> check_token(std::string_view token) {
  if (token.size() < kMinTokenBytes || token.size() > kMaxTokenBytes) {
    return refused("a token must have from " + std::to_string(kMinTokenBytes) + " to " +
                   std::to_string(kMaxTokenBytes) + " characters; use random ones");
  }
  if (std::all_of(token.begin(), token.end(), is_token68_char)) return Done{};
  return refused("a token must be made of A-Z, a-z, 0-9 and -._~+/=");
}

std::string token_sha256(std::string_view token) {
  return api::sha256_hex(std::as_bytes(std::span(token.data(), token.size())));
}

std::string_view bearer_token(const Head& head) {
  std::string_view value = head.header("authorization");
  if (lower(next(value, " ")) != "bearer") return {};
  return trimmed(value);
}

bool same_digest(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace meshgauge::server
