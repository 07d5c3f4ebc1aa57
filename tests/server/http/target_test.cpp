#include "server/http/target.h"

#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

using meshgauge::server::Authority;
using meshgauge::server::parse_authority;
using meshgauge::server::parse_target;
using meshgauge::server::RequestTarget;

namespace {

// Splits a list, which clang-format would put one to a line, at its spaces.
std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

}  // namespace

TEST_CASE("target: the four forms, and what each consists of") {
  using Form = RequestTarget::Form;
  struct Row {
    std::string_view text;
    Form form;
    std::string_view authority, path, query;
  };
  const Row rows[] = {
      {"/", Form::origin, "", "/", ""},
      {"/v1/comparisons?limit=5", Form::origin, "", "/v1/comparisons", "limit=5"},
      {"/?", Form::origin, "", "/", ""},
      {"/a?b?c/d", Form::origin, "", "/a", "b?c/d"},
      {"//a", Form::origin, "", "//a", ""},
      {"/..;x=1/%2e%2E/:@!$&'()*+,=~_.-", Form::origin, "", "/..;x=1/%2e%2E/:@!$&'()*+,=~_.-", ""},
      {"/?u=http://host/x", Form::origin, "", "/", "u=http://host/x"},
      {"http://host", Form::absolute, "host", "/", ""},
      {"http://host/metrics", Form::absolute, "host", "/metrics", ""},
      {"HTTPS://Host:443/a?b", Form::absolute, "Host:443", "/a", "b"},
      {"http://h?x=/metrics", Form::absolute, "h", "/", "x=/metrics"},
      {"http://[::1]:80/healthz", Form::absolute, "[::1]:80", "/healthz", ""},
      {"http://host:/x", Form::absolute, "host:", "/x", ""},
      {"host:443", Form::authority, "host:443", "", ""},
      {"[2001:db8::1]:443", Form::authority, "[2001:db8::1]:443", "", ""},
      {"*", Form::asterisk, "", "*", ""},
  };
  for (const Row& row : rows) {
    INFO(row.text);
    const auto target = parse_target(row.text);
    REQUIRE(target);
    CHECK(target->form == row.form);
    CHECK(target->authority == row.authority);
    CHECK(target->path == row.path);
    CHECK(target->query == row.query);
  }
}

TEST_CASE("target: what the grammar does not have is refused") {
  for (const std::string& text : words(R"(
      ** *?x metrics example.org ?x=1 /a#b /" /< /> /\ /^ /` /{ /| /} /[ /] /?[ /% /%2 /%2g /%zz /?%2
      http:// http:///x http://:80/x http://user@host/x http://user:password@host/ http://host:80x/
      http://[::1/x http://[::1]x/ http://[::1]:x/ http://h#x http://h|/ http:/host/ http:host
      ftp://host/ ://host/ host: host:80/x user@host:80 :80)")) {
    CHECK_MESSAGE(!parse_target(text), text);
  }
  for (const std::string_view text : {"", " ", "/a b", "http://ho st/", "/\x7f", "/\xc3\xa9"}) {
    CHECK_MESSAGE(!parse_target(text), text);
  }
  CHECK(!parse_target(std::string_view("/\0", 2)));
  CHECK(!parse_target(std::string_view("http://1.2.3.4\0/", 16)));
}

TEST_CASE("target: hosts and their ports") {
  using Kind = Authority::Kind;
  struct Row {
    std::string_view text;
    Kind kind;
    std::string_view host, port;
  };
  const Row rows[] = {
      {"", Kind::name, "", ""},
      {"localhost", Kind::name, "localhost", ""},
      {"Gauge.example:8080", Kind::name, "Gauge.example", "8080"},
      {"gauge_1:", Kind::name, "gauge_1", ""},
      {"loc%61lhost", Kind::name, "loc%61lhost", ""},
      {":80", Kind::name, "", "80"},
      {"127.0.0.1:8080", Kind::ipv4, "127.0.0.1", "8080"},
      {"255.255.255.255", Kind::ipv4, "255.255.255.255", ""},
      // Names to the grammar, though some programs read them as addresses.
      {"127.1", Kind::name, "127.1", ""},
      {"127.0.0.01", Kind::name, "127.0.0.01", ""},
      {"256.0.0.1", Kind::name, "256.0.0.1", ""},
      {"127.0.0.1.evil.example", Kind::name, "127.0.0.1.evil.example", ""},
      {"[::]", Kind::ipv6, "[::]", ""},
      {"[::1]:8080", Kind::ipv6, "[::1]", "8080"},
      {"[2001:DB8:0:0:1::]", Kind::ipv6, "[2001:DB8:0:0:1::]", ""},
      {"[1:2:3:4:5:6:7:8]", Kind::ipv6, "[1:2:3:4:5:6:7:8]", ""},
      {"[::ffff:192.0.2.1]:1", Kind::ipv6, "[::ffff:192.0.2.1]", "1"},
  };
  for (const Row& row : rows) {
    INFO(row.text);
    const auto authority = parse_authority(row.text);
    REQUIRE(authority);
    CHECK(authority->kind == row.kind);
    CHECK(authority->host == row.host);
    CHECK(authority->port == row.port);
  }
  for (const std::string& text : words(R"(
      [::1].evil.example localhost:x.evil localhost:80:80 localhost:-1 user@localhost a/b a,b|c ::1
      [] [ ] [::1 [::1]] [[::1]] [1.2.3.4] [:::] [1::2::3] [1:2:3:4:5:6:7] [1:2:3:4:5:6:7:8:9] [12345::]
      [::1%25eth0] [fe80::1%eth0] [v1.x] [::256.0.0.1] % %6)")) {
    CHECK_MESSAGE(!parse_authority(text), text);
  }
  for (const std::string_view text : {"localhost: 80", "a b", "[::1 ]", "h\xc3\xa9"}) {
    CHECK_MESSAGE(!parse_authority(text), text);
  }
  CHECK(!parse_authority(std::string_view("[::1\0]", 6)));
}
