// The file of keys: who may use the service, for what, and how much of it.
//
//   {"keys": [{"id": "ci", "sha256": "<of the token>", "scopes": ["compare"], "requests_per_minute": 600, "burst": 100,
//              "max_jobs": 8, "max_storage_bytes": 10737418240, "expires": "2027-01-01T00:00:00Z", "disabled": false}]}
//
// Of a key, only `id` and `sha256` must be there. `sha256` may be an array of up to four: while a token is being
// replaced, the old and the new one open the same door.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"

namespace meshgauge::server {

enum class Scope { compare, metrics };

struct Scopes {
  bool compare = false;
  bool metrics = false;
};

// What a key that says nothing else gets.
struct Allowance {
  std::uint64_t requests_per_minute = 600;
  std::uint64_t burst = 100;                                  // requests at once
  std::uint64_t max_jobs = 8;                                 // queued and running
  std::uint64_t max_storage_bytes = std::uint64_t{10} << 30;  // of stored meshes
};

struct Key {
  std::string id;  // owns what is stored with the key; never empty
  std::vector<std::string> sha256;
  Scopes scopes{true, false};
  Allowance allowance;
  std::optional<std::chrono::system_clock::time_point> expires;
  bool disabled = false;
};

inline constexpr std::size_t kMaxKeys = 10'000;

// Strictly: an unknown or repeated field, a wrong type, an impossible number, an id or a token that is there twice is
// refused, with the line or the JSON pointer in the message.
Result<std::vector<Key>> parse_keys(std::string_view json);

Result<std::vector<Key>> load_keys(const std::string& file);  // messages begin with the file

Result<Done> check_key_id(std::string_view id);  // 1 to 64 of A-Z, a-z, 0-9, '-', '_' and '.'

// The name of the scope, or nullopt.
std::optional<Scope> scope_of(std::string_view name);

std::string to_json(const Key& key);  // one entry of a file, on one line

}  // namespace meshgauge::server
