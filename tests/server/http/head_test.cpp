#include "server/http/head.h"

#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using api::ProblemKind;
using server::Head;

namespace {

constexpr std::uint64_t kLimit = 1000;

Head accepted(const std::string& text) {
  Head head;
  const auto refusal = server::parse_head(text, kLimit, head);
  REQUIRE_MESSAGE(!refusal, text << " -> " << refusal->detail);
  return head;
}

ProblemKind refusal_of(const std::string& text) {
  Head head;
  const auto refusal = server::parse_head(text, kLimit, head);
  REQUIRE_MESSAGE(refusal.has_value(), text);
  return refusal->kind;
}

std::string get(const std::string& fields) { return "GET / HTTP/1.1\r\nHost: x\r\n" + fields + "\r\n"; }
std::string post(const std::string& fields) { return "POST / HTTP/1.1\r\nHost: x\r\n" + fields + "\r\n"; }

}  // namespace

TEST_CASE("head: an ordinary request") {
  const Head head = accepted(
      "POST /v1/comparisons?x=1 HTTP/1.1\r\nHost: x\r\nContent-TYPE:  multipart/form-data; boundary=z \r\n"
      "content-length: 12\r\nExpect: 100-continue\r\n\r\n");
  CHECK(head.method == "POST");
  CHECK(head.path == "/v1/comparisons");
  CHECK(head.query == "x=1");
  CHECK(head.header("content-type") == "multipart/form-data; boundary=z");
  CHECK(head.content_length == 12);
  CHECK(head.expects_continue);
  CHECK(head.keep_alive);
  CHECK(!head.chunked);
}

TEST_CASE("head: which requests keep the connection open") {
  CHECK(!accepted(get("Connection: close\r\n")).keep_alive);
  CHECK(!accepted(get("Connection: foo, Close\r\n")).keep_alive);
  CHECK(accepted(get("Connection: keep-alive\r\n")).keep_alive);
  CHECK(!accepted("GET / HTTP/1.0\r\n\r\n").keep_alive);
}

TEST_CASE("head: the absolute form of a target is accepted") {
  CHECK(accepted("GET http://host:80/healthz HTTP/1.1\r\nHost: x\r\n\r\n").path == "/healthz");
  CHECK(accepted("GET http://host HTTP/1.1\r\nHost: x\r\n\r\n").path == "/");
  const Head head = accepted("GET HTTPS://host?x=/metrics HTTP/1.1\r\nHost: x\r\n\r\n");
  CHECK(head.path == "/");
  CHECK(head.query == "x=/metrics");
  CHECK(refusal_of("GET http://ho\nst/ HTTP/1.1\r\nHost: x\r\n\r\n") == ProblemKind::malformed_request);
  CHECK(refusal_of("GET http://ho\x01st/ HTTP/1.1\r\nHost: x\r\n\r\n") == ProblemKind::malformed_request);
}

TEST_CASE("head: a target that names its host replaces Host") {
  CHECK(accepted("GET http://host:80/ HTTP/1.1\r\nHost: x\r\n\r\n").header("host") == "host:80");
  CHECK(accepted("GET http://host/ HTTP/1.0\r\n\r\n").header("host") == "host");
  CHECK(accepted("GET / HTTP/1.1\r\nHost: x\r\n\r\n").header("host") == "x");
  CHECK(refusal_of("GET http://host/ HTTP/1.1\r\n\r\n") == ProblemKind::malformed_request);  // no Host
}

TEST_CASE("head: a Host that the grammar does not have is refused") {
  for (const char* host : {"localhost:x.evil", "[::1].evil.example", "user@localhost", "a b", "::1", "a|b"}) {
    INFO(host);
    CHECK(refusal_of(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n") == ProblemKind::malformed_request);
  }
  CHECK(accepted("GET / HTTP/1.1\r\nHost:\r\n\r\n").header("host").empty());
  CHECK(accepted("OPTIONS * HTTP/1.1\r\nHost: [::1]:8080\r\n\r\n").path == "*");
}

TEST_CASE("head: a malformed request line is refused") {
  for (const char* line :
       {"GET /", "GET", "", "GET  / HTTP/1.1", "GET / HTTP/1.1 ", "G\x01T / HTTP/1.1", "/ GET HTTP/1.1",
        "GET example.org HTTP/1.1", "GET example.org:80 HTTP/1.1", "CONNECT example.org:443 HTTP/1.1", "GET * HTTP/1.1",
        "GET http://user@host/ HTTP/1.1", "GET http:///x HTTP/1.1", "GET /| HTTP/1.1", "GET /%zz HTTP/1.1",
        "GET /a\tb HTTP/1.1", "GET /\xc3\xa9 HTTP/1.1", "GET /#x HTTP/1.1"}) {
    Head head;
    CHECK_MESSAGE(server::parse_head(std::string(line) + "\r\nHost: x\r\n\r\n", kLimit, head).has_value(), line);
  }
  CHECK(refusal_of("GET / HTTP/2.0\r\nHost: x\r\n\r\n") == ProblemKind::http_version);
  CHECK(refusal_of("BREW / HTTP/1.1\r\nHost: x\r\n\r\n") == ProblemKind::not_implemented);
  CHECK(refusal_of("GET /" + std::string(3000, 'a') + " HTTP/1.1\r\nHost: x\r\n\r\n") == ProblemKind::uri_too_long);
}

TEST_CASE("head: what two parsers could read differently is refused") {
  const char* fields[] = {"Content-Length: 5\r\nContent-Length: 5\r\n",
                          "Content-Length: 5\r\nContent-Length: 6\r\n",
                          "Content-Length: 5, 5\r\n",
                          "Content-Length: +5\r\n",
                          "Content-Length: 0x5\r\n",
                          "Content-Length: -1\r\n",
                          "Content-Length:\r\n",
                          "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
                          "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
                          "Content-Length : 5\r\n",
                          "Transfer-Encoding : chunked\r\n",
                          "X: a\r\n folded\r\n",
                          "X: a\rb\r\n",
                          "X: a\nContent-Length: 5\r\n",
                          ": empty\r\n",
                          "no colon\r\n",
                          "Host: y\r\n"};
  for (const char* field : fields) CHECK_MESSAGE(refusal_of(post(field)) == ProblemKind::malformed_request, field);
  CHECK(refusal_of(post(std::string("X: a\0b\r\n", 8))) == ProblemKind::malformed_request);
  CHECK(refusal_of("GET / HTTP/1.1\r\n\r\n") == ProblemKind::malformed_request);  // no Host
  CHECK(refusal_of("POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n") == ProblemKind::malformed_request);
}

TEST_CASE("head: unknown codings are refused") {
  CHECK(refusal_of(post("Transfer-Encoding: gzip, chunked\r\n")) == ProblemKind::not_implemented);
  CHECK(refusal_of(post("Transfer-Encoding: chunked, identity\r\n")) == ProblemKind::not_implemented);
  CHECK(refusal_of(post("Transfer-Encoding: xchunked\r\n")) == ProblemKind::not_implemented);
  CHECK(refusal_of(post("Content-Length: 5\r\nContent-Encoding: gzip\r\n")) == ProblemKind::unsupported_media_type);
  CHECK(accepted(post("Transfer-Encoding: Chunked\r\n")).chunked);
}

TEST_CASE("head: a body needs a length within the limit") {
  CHECK(refusal_of(post("")) == ProblemKind::length_required);
  CHECK(accepted(post("Content-Length: 1000\r\n")).content_length == kLimit);
  CHECK(refusal_of(post("Content-Length: 1001\r\n")) == ProblemKind::too_large);
  CHECK(refusal_of(post("Content-Length: 99999999999999999999999\r\n")) == ProblemKind::too_large);
}

TEST_CASE("head: a head that grows too long is refused while it arrives") {
  CHECK(!server::check_incomplete("GET / HTTP/1.1\r\nHost: x\r\n"));
  CHECK(server::check_incomplete("\x16\x03\x01")->kind == ProblemKind::malformed_request);  // it is TLS
  CHECK(server::check_incomplete(std::string(3000, 'a'))->kind == ProblemKind::uri_too_long);
  CHECK(server::check_incomplete("GET / HTTP/1.1\r\n" + std::string(server::kMaxHeadBytes, 'a'))->kind ==
        ProblemKind::head_too_large);
  CHECK(server::check_incomplete("GET / HTTP/1.1\nHost: x\n\n")->kind == ProblemKind::malformed_request);
}
