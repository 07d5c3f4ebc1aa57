// Bearer tokens (RFC 6750): creating them, hashing them for the keys file, and finding them in a request.
#pragma once

#include <string>
#include <string_view>

#include "engine/result.h"
#include "server/http/head.h"

namespace meshgauge::server {

// The keys file holds the plain SHA-256 of a token. That is safe only for tokens that cannot be guessed, hence the
// minimum length for tokens that an operator supplies.
inline constexpr std::size_t kMinTokenBytes = 32;
inline constexpr std::size_t kMaxTokenBytes = 512;

std::string new_token();  // 256 random bits, as "mg_" and 64 hex digits

Result<Done> check_token(std::string_view token);      // checks length and characters (RFC 6750 section 2.1)
std::string token_sha256(std::string_view token);      // 64 lower-case hex digits
std::string_view bearer_token(const Head& head);       // the token in Authorization; empty: none
bool same_digest(std::string_view, std::string_view);  // compares in a time that depends on the lengths only

}  // namespace meshgauge::server
