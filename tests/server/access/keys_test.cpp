#include "server/access/keys.h"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

#include "api/base/utc.h"

using namespace meshgauge;
using server::Key;
using server::parse_keys;

namespace {

const std::string kDigest(64, 'a');
const std::string kOther(64, 'b');

std::string entry(const std::string& more = "", const std::string& id = "ci", const std::string& digest = kDigest) {
  return R"({"id": ")" + id + R"(", "sha256": ")" + digest + "\"" + more + "}";
}

std::string file(const std::string& entries) { return "{\"keys\": [" + entries + "]}"; }

std::string refusal(const std::string& text) {
  const auto keys = parse_keys(text);
  REQUIRE_MESSAGE(!keys.ok(), text);
  return keys.error().message;
}

}  // namespace

TEST_CASE("keys: id and token are required, the rest has defaults") {
  const auto keys = parse_keys(file(entry()));
  REQUIRE(keys.ok());
  REQUIRE(keys->size() == 1);
  const Key& key = keys->front();
  CHECK(key.id == "ci");
  CHECK(key.sha256 == std::vector{kDigest});
  CHECK(key.scopes.compare);
  CHECK(!key.scopes.metrics);
  CHECK(key.allowance.requests_per_minute == 600);
  CHECK(key.allowance.max_jobs == 8);
  CHECK(!key.expires);
  CHECK(!key.disabled);
  CHECK(parse_keys(file(""))->empty());
}

TEST_CASE("keys: to_json() is read back unchanged") {
  Key key;
  key.id = "a-1_b.C";
  key.sha256 = {kDigest, kOther};
  key.scopes = {false, true};
  key.allowance = {1, 2, 3, 0};
  key.expires = api::parse_utc("2027-01-31T12:34:56Z");
  key.disabled = true;
  const auto keys = parse_keys(file(to_json(key)));
  REQUIRE(keys.ok());
  const Key& read = keys->front();
  CHECK(read.id == key.id);
  CHECK(read.sha256 == key.sha256);
  CHECK(!read.scopes.compare);
  CHECK(read.scopes.metrics);
  CHECK(read.allowance.requests_per_minute == 1);
  CHECK(read.allowance.burst == 2);
  CHECK(read.allowance.max_jobs == 3);
  CHECK(read.allowance.max_storage_bytes == 0);
  CHECK(read.expires == key.expires);
  CHECK(read.disabled);
}

TEST_CASE("keys: invalid files are refused with the place of the error") {
  CHECK(refusal("{\n\"keys\": [\n{]\n}").starts_with("line 3: not JSON"));
  CHECK(refusal(std::string("{\"keys\": []}\0", 13)) == "not JSON: has a NUL byte");
  CHECK(refusal("[]").starts_with("must be an object with the one field 'keys'"));
  CHECK(refusal(R"({"keys": [], "more": 1})").starts_with("must be an object with the one field 'keys'"));
  CHECK(refusal(file(entry(R"(, "rate": 1)"))).starts_with("/keys/0: unknown field 'rate'; known: id, sha256, scopes"));
  CHECK(refusal(file(entry() + ", " + entry(R"(, "disabled": true, "disabled": false)", "other", kOther))) ==
        "/keys/1/disabled: the key 'disabled' occurs twice in one object");
  CHECK(refusal(file(R"({"id": "ci"})")) == "/keys/0: the field 'sha256' is missing");
  CHECK(refusal(file(R"({"sha256": ")" + kDigest + "\"}")) == "/keys/0: the field 'id' is missing");
  CHECK(refusal(file("7")) == "/keys/0: must be an object, not 7");
}

TEST_CASE("keys: impossible values are refused") {
  CHECK(refusal(file(entry("", "has space"))).starts_with("/keys/0/id: an id has"));
  CHECK(refusal(file(entry("", ""))).starts_with("/keys/0/id: an id has"));
  CHECK(refusal(file(entry("", std::string(65, 'x')))).starts_with("/keys/0/id: an id has"));
  CHECK(refusal(file(entry("", "ci", std::string(63, 'a')))).starts_with("/keys/0/sha256: must be the SHA-256"));
  CHECK(refusal(file(entry("", "ci", std::string(64, 'A')))).starts_with("/keys/0/sha256: must be the SHA-256"));
  CHECK(refusal(file(R"({"id": "x", "sha256": []})")).starts_with("/keys/0/sha256: must be one digest"));
  CHECK(refusal(file(entry(R"(, "scopes": ["compare", "admin"])"))) ==
        R"(/keys/0/scopes/1: must be "compare" or "metrics", not 'admin')");
  CHECK(refusal(file(entry(R"(, "scopes": [])"))).starts_with("/keys/0/scopes: must be an array"));
  CHECK(refusal(file(entry(R"(, "requests_per_minute": 0)"))) ==
        "/keys/0/requests_per_minute: must be an integer from 1 to 100000000, not 0");
  for (const char* value : {"-1", "1.5", "\"8\"", "null", "1e3", "18446744073709551616"}) {
    CHECK(
        refusal(file(entry(std::string(R"(, "max_jobs": )") + value))).starts_with("/keys/0/max_jobs: must be an int"));
  }
  CHECK(refusal(file(entry(R"(, "expires": "2027-02-30T00:00:00Z")"))).starts_with("/keys/0/expires: must be a time"));
  CHECK(refusal(file(entry(R"(, "expires": 5)"))).starts_with("/keys/0/expires: must be a time"));
  CHECK(refusal(file(entry(R"(, "disabled": 1)"))) == "/keys/0/disabled: must be true or false, not 1");
}

TEST_CASE("keys: an id or token that two keys share is refused") {
  CHECK(refusal(file(entry() + "," + entry("", "ci", kOther))) == "/keys/1/id: another key has the id 'ci' as well");
  CHECK(refusal(file(entry() + "," + entry("", "other"))) ==
        "/keys/1/sha256: this digest occurs twice in the file; give each key a token of its own");
}

TEST_CASE("keys: a file that cannot be read says why") {
  const auto message = [](const std::string& path) { return server::load_keys(path).error().message; };
  CHECK(message("/nonexistent/keys").find("No such file") != std::string::npos);
  CHECK(message("/tmp").starts_with("--keys-file '/tmp': "));
}

TEST_CASE("keys: a file that others can write is refused") {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("keys_test." + std::to_string(::getpid()))).string();
  std::ofstream(path) << file("");
  for (const mode_t mode : {0600U, 0640U, 0644U, 0440U}) {
    REQUIRE(::chmod(path.c_str(), mode) == 0);
    CHECK(server::load_keys(path).ok());
  }
  for (const mode_t mode : {0620U, 0602U, 0666U, 0664U}) {
    REQUIRE(::chmod(path.c_str(), mode) == 0);
    const auto refused = server::load_keys(path);
    REQUIRE(!refused.ok());
    CHECK(refused.error().message.find("chmod go-w") != std::string::npos);
  }
  std::filesystem::remove(path);
}

TEST_CASE("token: new ones are long, allowed and different") {
  const std::string token = server::new_token();
  CHECK(token.size() == 67);
  CHECK(token.starts_with("mg_"));
  CHECK(server::check_token(token).ok());
  CHECK(token != server::new_token());
  CHECK(!server::check_token(std::string(31, 'x')).ok());
  CHECK(server::check_token(std::string(32, 'x')).ok());
  CHECK(!server::check_token(std::string(513, 'x')).ok());
  CHECK(!server::check_token(std::string(40, 'x') + " ").ok());
  CHECK(server::token_sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST_CASE("token: found in the Authorization header") {
  const auto of = [](std::string value) {
    server::Head head;
    head.headers = {{"authorization", std::move(value)}};
    return std::string(server::bearer_token(head));
  };
  CHECK(of("Bearer abc") == "abc");
  CHECK(of("bEARER  abc ") == "abc");
  CHECK(of("Basic abc").empty());
  CHECK(of("Bearer").empty());
  CHECK(of("").empty());
  CHECK(server::bearer_token(server::Head{}).empty());
}

TEST_CASE("utc: round trip, and impossible times are refused") {
  for (const char* text : {"1970-01-01T00:00:00Z", "2024-02-29T23:59:59Z", "2200-12-31T00:00:01Z"}) {
    const auto time = api::parse_utc(text);
    REQUIRE(time);
    CHECK(api::to_utc(*time) == text);
  }
  for (const char* text : {"", "2027-01-01", "2027-01-01T00:00:00", "2027-01-01T00:00:00+01", "2027-13-01T00:00:00Z",
                           "2023-02-29T00:00:00Z", "2027-01-01T24:00:00Z", "2027-01-01T00:60:00Z",
                           "2027-01-01T00:00:60Z", "2027-01-0aT00:00:00Z", "9999-01-01T00:00:00Z"}) {
    CHECK_MESSAGE(!api::parse_utc(text), text);
  }
}
