// Bearer tokens (RFC 6750): how they are made, named in a file, and found in a request.
#pragma once

#include <string>
#include <string_view>

#include "engine/result.h"
#include "server/http/head.h"

namespace meshgauge::server {

// What a file of keys names in place of a token is its plain SHA-256. That is safe for what nobody can guess or try, so
// a token that somebody brings must be this long.
inline constexpr std::size_t kMinTokenBytes = 32;
inline constexpr std::size_t kMaxTokenBytes = 512;

std::string new_token();  // 256 random bits, as "mg_" and 64 hex digits

Result<Done> check_token(std::string_view token);      // length and characters (RFC 6750 section 2.1)
std::string token_sha256(std::string_view token);      // 64 lower-case hex digits
std::string_view bearer_token(const Head& head);       // of Authorization; empty: there is none
bool same_digest(std::string_view, std::string_view);  // in a time that depends on the lengths alone

}  // namespace meshgauge::server
