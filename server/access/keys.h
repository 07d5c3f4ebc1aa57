// Bearer keys (RFC 6750): the keys file, with their scopes and limits, and their tokens, which are created, hashed for
// the file, and found in a request.
//
//   {"keys": [{"id": "ci", "sha256": "<of the token>", "scopes": ["compare"], "requests_per_minute": 600, "burst": 100,
//              "max_jobs": 8, "max_storage_bytes": 10737418240, "expires": "2027-01-01T00:00:00Z", "disabled": false}]}
//
// Only `id` and `sha256` are required. `sha256` may be an array of up to four digests: while a token is being replaced,
// the old and the new one are valid for the same key.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"
#include "server/http/head.h"

namespace meshgauge::server {

enum class Scope { compare, metrics };

struct Scopes {
  bool compare = false;
  bool metrics = false;
};

// The limits of a key, with their defaults.
struct Allowance {
  std::uint64_t requests_per_minute = 600;
  std::uint64_t burst = 100;                                  // requests at once
  std::uint64_t max_jobs = 8;                                 // comparisons queued and running
  std::uint64_t max_storage_bytes = std::uint64_t{10} << 30;  // of stored meshes
};

struct Key {
  std::string id;  // owner of everything stored with the key; never empty
  std::vector<std::string> sha256;
  Scopes scopes{true, false};
  Allowance allowance;
  std::optional<std::chrono::system_clock::time_point> expires;
  bool disabled = false;
};

inline constexpr std::size_t kMaxKeys = 10'000;

// Parses the text of a keys file. Rejects unknown and repeated fields, wrong types, numbers out of range, and ids or
// tokens that occur twice; the message has the line or the JSON pointer.
Result<std::vector<Key>> parse_keys(std::string_view json);

// Messages begin with the file's name. A file that users other than its owner can write is refused.
Result<std::vector<Key>> load_keys(const std::string& file);

Result<Done> check_key_id(std::string_view id);  // valid: 1 to 64 of A-Z, a-z, 0-9, '-', '_' and '.'

std::optional<Scope> scope_of(std::string_view name);  // nullopt: no scope has this name

std::string to_json(const Key& key);  // an entry of a keys file, on one line

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
