#include "server/http/body.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <limits>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::Body;
using server::Connection;
using server::Head;

namespace {

// Receives what arrives in pieces of `step`, one at a time; the stream then ends unless it stays open.
struct BodyClient {
  std::array<int, 2> ends{-1, -1};
  Head head;
  std::string received;
  std::uint64_t limit = 1000;

  ~BodyClient() {
    for (const int end : ends) ::close(end);
  }

  // Returns the problem of the body; nullopt: none so far.
  std::optional<api::Problem> send(const std::string& sent, std::size_t step, bool& consumed) {
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) == 0);
    Connection connection(ends[0]);
    Body body(connection, head, limit);
    std::optional<api::Problem> problem;
    body.read(
        [&](std::string_view piece) {
          received.append(piece);
          return std::optional<api::Problem>();
        },
        [&](const Body::Refusal& refusal) { problem = refusal; });
    std::size_t i = 0;
    for (auto got = body.go_on(); got == Body::Step::wants_read && i < sent.size(); i += step) {
      const std::string piece = sent.substr(i, step);
      REQUIRE(::send(ends[1], piece.data(), piece.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(piece.size()));
      got = body.go_on();
    }
    waits = body.reading();
    if (waits) {
      ::shutdown(ends[1], SHUT_WR);
      closed = body.go_on() == Body::Step::closed;
      body.abandon();
    }
    consumed = body.consumed();
    rest = connection.buffered();
    return problem;
  }

  std::string rest;
  bool waits = false;   // for more than was sent
  bool closed = false;  // and noticed the end of the stream
};

struct BodyOutcome {
  std::string received;
  std::string rest;
  bool consumed = false;
  std::optional<api::ProblemKind> problem;
  bool lacking = false;
};

BodyOutcome chunked(const std::string& sent, std::size_t step) {
  BodyClient client;
  client.head.chunked = true;
  bool consumed = false;
  const auto refusal = client.send(sent, step, consumed);
  return {client.received, client.rest, consumed, refusal ? std::optional(refusal->kind) : std::nullopt,
          client.waits && client.closed};
}

BodyOutcome sized(const std::string& sent, std::uint64_t length) {
  BodyClient client;
  client.head.content_length = length;
  bool consumed = false;
  const auto refusal = client.send(sent, 3, consumed);
  return {client.received, client.rest, consumed, refusal ? std::optional(refusal->kind) : std::nullopt,
          client.waits && client.closed};
}

}  // namespace

TEST_CASE("body: a chunked body is reassembled however its bytes arrive") {
  const std::string sent = "5\r\nhello\r\n1;ext=\"x\"\r\n \r\n005\r\nworld\r\n0\r\nTrailer: x\r\n\r\nNEXT";
  for (const std::size_t step : {1U, 2U, 3U, 7U, 100U}) {
    const BodyOutcome outcome = chunked(sent, step);
    CHECK(outcome.received == "hello world");
    CHECK(outcome.consumed);
    CHECK(!outcome.problem);
  }
  CHECK(chunked(sent, 1000).rest == "NEXT");
}

TEST_CASE("body: a malformed chunk is refused, and the rest is not a request") {
  for (const char* sent :
       {"x\r\n", "\r\nhello\r\n", "5 \r\nhello\r\n", "-1\r\n", "0x5\r\nhello\r\n", "5\r\nhelloX\r\n0\r\n\r\n",
        "5\nhello\n0\n\n", "11111111111111111\r\n", "5;a\nb\r\nhello\r\n0\r\n\r\n", "5;a\rb\r\nhello\r\n0\r\n\r\n",
        "0\r\nT: x\n\nGET / HTTP/1.1\r\n\r\n"}) {
    const BodyOutcome outcome = chunked(sent, 100);
    CHECK_MESSAGE((outcome.problem == api::ProblemKind::malformed_request || outcome.lacking), sent);
    CHECK(!outcome.consumed);
  }
  CHECK(chunked(std::string(1000, '1'), 100).problem == api::ProblemKind::malformed_request);
  std::string trailers = "0\r\n";
  for (int i = 0; i < 100; ++i) trailers += "T: x\r\n";
  CHECK(chunked(trailers + "\r\n", 100).problem == api::ProblemKind::malformed_request);
  const std::string long_text(1000, 'x');
  CHECK(chunked("0\r\nT: " + long_text + "\r\n\r\n", 100).problem == api::ProblemKind::malformed_request);
  CHECK(chunked("5;" + long_text + "\r\nhello\r\n", 100).problem == api::ProblemKind::malformed_request);
}

TEST_CASE("body: many small chunks count against the limit") {
  std::string sent;
  for (int i = 0; i < 101; ++i) sent += "a\r\n0123456789\r\n";
  CHECK(chunked(sent + "0\r\n\r\n", 100).problem == api::ProblemKind::too_large);
  CHECK(chunked("3e9\r\n", 100).problem == api::ProblemKind::too_large);
  CHECK(chunked("ffffffffffffffff\r\n", 100).problem == api::ProblemKind::too_large);
}

TEST_CASE("body: a body of a known length ends there") {
  CHECK(sized("hello", 5).received == "hello");
  CHECK(sized("helloNEXT", 5).received == "hello");
  CHECK(sized("hello", 5).consumed);
  CHECK(sized("hell", 5).lacking);
  CHECK(sized("", 0).consumed);
}

TEST_CASE("body: a body that ends too soon is waited for") {
  CHECK(sized("hell", 5).lacking);
  CHECK(chunked("5\r\nhel", 100).lacking);
  CHECK(chunked("5\r\nhello\r\n0\r\nT: x\r\n", 100).lacking);
}

TEST_CASE("body: a client that expects 100 Continue is invited, unless it sends already") {
  std::array<int, 2> ends{-1, -1};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) == 0);
  Connection connection(ends[0]);
  Head head;
  head.content_length = 5;
  head.expects_continue = true;
  for (const bool invited : {true, false}) {
    Body body(connection, head, 1000);
    body.read([](auto) { return Body::Refusal(); }, [](const auto&) {});
    CHECK(body.go_on() == Body::Step::wants_read);
    std::array<char, 100> answer{};
    const ssize_t got = ::recv(ends[1], answer.data(), answer.size(), 0);
    CHECK((got > 0 && std::string(answer.data()).starts_with("HTTP/1.1 100 Continue\r\n\r\n")) == invited);
    REQUIRE(::send(ends[1], "hello12345", 10, MSG_NOSIGNAL) == 10);
    CHECK(body.go_on() == Body::Step::done);
    if (!invited) continue;
    CHECK(connection.buffered() == "12345");
    connection.consume(4);
  }
  for (const int end : ends) ::close(end);
}

TEST_CASE("body: what is left of a body is known if the client is sure to send it") {
  std::array<int, 2> ends{-1, -1};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
  Connection connection(ends[0]);
  constexpr auto unknown = std::numeric_limits<std::uint64_t>::max();
  Head head;
  head.content_length = 5;
  CHECK(Body(connection, head, 1000).left() == 5);
  head.expects_continue = true;
  CHECK(Body(connection, head, 1000).left() == unknown);
  REQUIRE(::send(ends[1], "hel", 3, MSG_NOSIGNAL) == 3);
  REQUIRE(connection.receive(100) == server::Transport::Step::done);
  Body body(connection, head, 1000);
  CHECK(body.left() == 5);
  body.read([](auto) { return std::optional(server::malformed("refused")); }, [](const auto&) {});
  CHECK(body.go_on() == Body::Step::done);
  CHECK(body.left() == 2);
  head.content_length.reset();
  CHECK(Body(connection, head, 1000).left() == 0);
  head.chunked = true;
  CHECK(Body(connection, head, 1000).left() == unknown);
  for (const int end : ends) ::close(end);
}
