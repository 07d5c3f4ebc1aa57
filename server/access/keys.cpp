#include "server/access/keys.h"

#include <sys/stat.h>

#include <algorithm>
#include <set>
#include <span>

#include <openssl/crypto.h>
#include <nlohmann/json.hpp>

#include "api/base/digest.h"
#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utc.h"
#include "api/base/whole_file.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using JsonValue = nlohmann::json;

constexpr std::size_t kMaxTokensOfKey = 4;
constexpr std::size_t kMaxKeysFileBytes = std::size_t{16} << 20;

Error bad_key(const std::string& where, const std::string& what) {
  return refused((where.empty() ? "" : where + ": ") + what, "", where);
}

Error wrong(const std::string& pointer, const char* expected, const JsonValue& value) {
  return bad_key(pointer, std::string("must be ") + expected + ", not " + api::shown(value));
}

using Reader = Result<Done> (*)(const JsonValue& value, const std::string& pointer, Key& key);

Result<Done> read_id(const JsonValue& value, const std::string& pointer, Key& key) {
  if (!value.is_string()) return wrong(pointer, "a text", value);
  key.id = value.get<std::string>();
  const auto ok = check_key_id(key.id);
  return ok ? ok : bad_key(pointer, ok.error().message);
}

bool is_digest(const JsonValue& value) {
  return value.is_string() && api::is_lower_hex(value.get_ref<const std::string&>(), 64);
}

Result<Done> read_sha256(const JsonValue& value, const std::string& pointer, Key& key) {
  const JsonValue list = value.is_array() ? value : JsonValue::array({value});
  if (list.empty() || list.size() > kMaxTokensOfKey)
    return bad_key(pointer, "must be one digest, or an array of 1 to 4 digests");
  for (const JsonValue& digest : list) {
    // The value is not shown: it may be the token itself, and this message is logged.
    if (!is_digest(digest)) {
      return bad_key(pointer,
                     "must be the SHA-256 of a token, 64 lower-case hex digits: `meshgauge keys hash` prints it");
    }
    key.sha256.push_back(digest.get<std::string>());
  }
  return Done{};
}

Result<Done> read_scopes(const JsonValue& value, const std::string& pointer, Key& key) {
  if (!value.is_array() || value.empty()) return wrong(pointer, R"(an array of "compare" and "metrics")", value);
  key.scopes = {};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto scope = value[i].is_string() ? scope_of(value[i].get_ref<const std::string&>()) : std::nullopt;
    if (!scope) return wrong(pointer + "/" + std::to_string(i), R"("compare" or "metrics")", value[i]);
    (*scope == Scope::compare ? key.scopes.compare : key.scopes.metrics) = true;
  }
  return Done{};
}

Result<std::uint64_t> read_integer(const JsonValue& value, const std::string& pointer, std::uint64_t low,
                                   std::uint64_t high) {
  const bool fits =
      value.is_number_unsigned() && value.get<std::uint64_t>() >= low && value.get<std::uint64_t>() <= high;
  if (fits) return value.get<std::uint64_t>();
  return wrong(pointer, ("an integer from " + std::to_string(low) + " to " + std::to_string(high)).c_str(), value);
}

template <std::uint64_t Allowance::*Field, std::uint64_t Low, std::uint64_t High>
Result<Done> read_limit(const JsonValue& value, const std::string& pointer, Key& key) {
  const auto number = read_integer(value, pointer, Low, High);
  if (!number) return number.error();
  key.allowance.*Field = *number;
  return Done{};
}

Result<Done> read_expires(const JsonValue& value, const std::string& pointer, Key& key) {
  if (value.is_null()) return Done{};
  if (value.is_string()) key.expires = api::parse_utc(value.get_ref<const std::string&>());
  return key.expires ? Result<Done>(Done{}) : wrong(pointer, "a time like 2027-01-31T12:00:00Z, or null", value);
}

Result<Done> read_disabled(const JsonValue& value, const std::string& pointer, Key& key) {
  if (!value.is_boolean()) return wrong(pointer, "true or false", value);
  key.disabled = value.get<bool>();
  return Done{};
}

struct Field {
  std::string_view name;
  Reader read;
};

constexpr Field kFields[] = {
    {"id", read_id},
    {"sha256", read_sha256},
    {"scopes", read_scopes},
    {"requests_per_minute", read_limit<&Allowance::requests_per_minute, 1, 100'000'000>},
    {"burst", read_limit<&Allowance::burst, 1, 1'000'000>},
    {"max_jobs", read_limit<&Allowance::max_jobs, 1, 100'000>},
    {"max_storage_bytes", read_limit<&Allowance::max_storage_bytes, 0, std::uint64_t{1} << 50>},
    {"expires", read_expires},
    {"disabled", read_disabled}};

std::string known_fields() {
  std::vector<std::string_view> names;
  for (const Field& field : kFields) names.push_back(field.name);
  return api::listed(names);
}

Result<Key> read_key(const JsonValue& entry, const std::string& pointer) {
  if (!entry.is_object()) return wrong(pointer, "an object", entry);
  Key key;
  for (const auto& [name, value] : entry.items()) {
    const auto* field = std::find_if(std::begin(kFields), std::end(kFields),
                                     [&, wanted = std::string_view(name)](const Field& f) { return f.name == wanted; });
    if (field == std::end(kFields)) {
      return bad_key(pointer, "unknown field " + api::shown_text(name) + "; known: " + known_fields());
    }
    if (auto ok = field->read(value, pointer + "/" + std::string(field->name), key); !ok) return ok.error();
  }
  if (key.id.empty()) return bad_key(pointer, "the field 'id' is missing");
  if (key.sha256.empty()) return bad_key(pointer, "the field 'sha256' is missing");
  return key;
}

Result<std::vector<Key>> read_all(const JsonValue& document) {
  if (!document.is_object() || document.size() != 1 || !document.contains("keys") || !document["keys"].is_array()) {
    return bad_key("", "must be an object with the one field 'keys', an array of keys");
  }
  const JsonValue& entries = document["keys"];
  if (entries.size() > kMaxKeys) return bad_key("/keys", "has more than " + std::to_string(kMaxKeys) + " keys");
  std::vector<Key> keys;
  std::set<std::string> ids;
  std::set<std::string> digests;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string pointer = "/keys/" + std::to_string(i);
    auto key = read_key(entries[i], pointer);
    if (!key) return key.error();
    if (!ids.insert(key->id).second)
      return bad_key(pointer + "/id", "another key has the id '" + key->id + "' as well");
    for (const std::string& digest : key->sha256) {
      if (!digests.insert(digest).second)
        return bad_key(pointer + "/sha256", "this digest occurs twice in the file; give each key a token of its own");
    }
    keys.push_back(std::move(*key));
  }
  return keys;
}

bool others_can_write(const std::string& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && (status.st_mode & (S_IWGRP | S_IWOTH)) != 0;
}

// Converts the JSON library's "byte N" to a line number.
std::string line_of(std::string_view text, std::string_view where) {
  if (!where.starts_with("byte ")) return std::string(where);
  const std::size_t byte = std::min<std::size_t>(std::stoull(std::string(where.substr(5))), text.size());
  return "line " + std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n'));
}

bool is_token68_char(char c) {
  return is_digit(c) || is_letter(c) || std::string_view("-._~+/=").find(c) != std::string::npos;
}

}  // namespace

Result<std::vector<Key>> parse_keys(std::string_view json) {
  if (json.find('\0') != std::string_view::npos)
    return bad_key("", "not JSON: has a NUL byte");  // the parser would stop at it
  api::JsonFilter filter;
  if (!JsonValue::sax_parse(json, &filter)) return bad_key(line_of(json, filter.where), filter.defect);
  return read_all(JsonValue::parse(json));
}

Result<std::vector<Key>> load_keys(const std::string& file) {
  const auto failed = [&](const std::string& why) { return refused("--keys-file '" + file + "': " + why); };
  if (others_can_write(file)) {
    return failed("users other than its owner can write it, and so give themselves a key; run chmod go-w");
  }
  const auto text = api::read_text_file(file, kMaxKeysFileBytes);
  if (!text) return failed(text.error().message);
  auto keys = parse_keys(*text);
  return keys ? keys : failed(keys.error().message);
}

Result<Done> check_key_id(std::string_view id) {
  const bool allowed = !id.empty() && id.size() <= 64 && std::all_of(id.begin(), id.end(), [](char c) {
    return is_digit(c) || is_letter(c) || c == '-' || c == '_' || c == '.';
  });
  if (allowed) return Done{};
  return refused("an id has 1 to 64 of A-Z, a-z, 0-9, '-', '_' and '.'");
}

std::optional<Scope> scope_of(std::string_view name) {
  if (name == "compare") return Scope::compare;
  if (name == "metrics") return Scope::metrics;
  return std::nullopt;
}

std::string to_json(const Key& key) {
  nlohmann::ordered_json scopes = nlohmann::ordered_json::array();
  if (key.scopes.compare) scopes.push_back("compare");
  if (key.scopes.metrics) scopes.push_back("metrics");
  nlohmann::ordered_json json{
      {"id", key.id},
      {"sha256", key.sha256.size() == 1 ? nlohmann::ordered_json(key.sha256[0]) : nlohmann::ordered_json(key.sha256)},
      {"scopes", scopes},
      {"requests_per_minute", key.allowance.requests_per_minute},
      {"burst", key.allowance.burst},
      {"max_jobs", key.allowance.max_jobs},
      {"max_storage_bytes", key.allowance.max_storage_bytes},
      {"expires", nullptr},
      {"disabled", key.disabled}};
  if (key.expires) json["expires"] = api::to_utc(*key.expires);
  return json.dump();
}

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
