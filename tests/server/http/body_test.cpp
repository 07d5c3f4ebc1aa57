#include "server/http/body.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::Body;
using server::Connection;
using server::Head;

namespace {

// Sends `sent` in pieces of `step`, then ends the stream unless the connection stays open.
struct BodyClient {
  std::array<int, 2> ends{-1, -1};
  std::atomic<bool> aborted{false};
  Head head;
  std::string received;
  std::uint64_t limit = 1000;
  bool stays = false;

  ~BodyClient() {
    for (const int end : ends) ::close(end);
  }

  std::optional<api::Problem> send(const std::string& sent, std::size_t step, bool& consumed) {
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
    std::thread sender([&] {
      for (std::size_t i = 0; i < sent.size(); i += step) {
        const std::string piece = sent.substr(i, step);
        if (::send(ends[1], piece.data(), piece.size(), MSG_NOSIGNAL) < 0) break;
      }
      if (!stays) ::shutdown(ends[1], SHUT_WR);
    });
    Connection connection(ends[0], aborted);
    Body body(connection, head, limit, stays ? std::chrono::milliseconds(300) : std::chrono::milliseconds(60'000));
    auto refusal = body.read([&](std::string_view piece) {
      received.append(piece);
      return std::optional<api::Problem>();
    });
    consumed = body.consumed();
    rest = connection.buffered();
    ::shutdown(ends[0], SHUT_RDWR);
    sender.join();
    return refusal;
  }

  std::string rest;
};

struct BodyOutcome {
  std::string received;
  std::string rest;
  bool consumed = false;
  std::optional<api::ProblemKind> problem;
};

BodyOutcome chunked(const std::string& sent, std::size_t step, bool stays = false) {
  BodyClient client;
  client.head.chunked = true;
  client.stays = stays;
  bool consumed = false;
  const auto refusal = client.send(sent, step, consumed);
  return {client.received, client.rest, consumed, refusal ? std::optional(refusal->kind) : std::nullopt};
}

BodyOutcome sized(const std::string& sent, std::uint64_t length, bool stays = false) {
  BodyClient client;
  client.head.content_length = length;
  client.stays = stays;
  bool consumed = false;
  const auto refusal = client.send(sent, 3, consumed);
  return {client.received, client.rest, consumed, refusal ? std::optional(refusal->kind) : std::nullopt};
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
    CHECK_MESSAGE(outcome.problem == api::ProblemKind::malformed_request, sent);
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
  CHECK(sized("hell", 5).problem == api::ProblemKind::malformed_request);
  CHECK(sized("", 0).consumed);
}

TEST_CASE("body: a body that does not arrive times out at the deadline") {
  CHECK(sized("hell", 5, true).problem == api::ProblemKind::request_timeout);
  CHECK(chunked("5\r\nhel", 100, true).problem == api::ProblemKind::request_timeout);
}

TEST_CASE("body: a shutdown while the body arrives is reported as a shutdown") {
  BodyClient client;
  client.head.content_length = 5;
  client.stays = client.aborted = true;
  bool consumed = false;
  const auto refusal = client.send("hell", 100, consumed);
  REQUIRE(refusal);
  CHECK(refusal->kind == api::ProblemKind::shutting_down);
  CHECK(!consumed);
}

TEST_CASE("body: the rest of a refused body is discarded if it has arrived, without waiting") {
  std::array<int, 2> ends{-1, -1};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
  const std::atomic<bool> aborted{false};
  Connection connection(ends[0], aborted);
  const auto deadline = server::Clock::now() + std::chrono::seconds(5);
  REQUIRE(::send(ends[1], "helloNEXT", 9, MSG_NOSIGNAL) == 9);
  REQUIRE(connection.fill(deadline) == server::Io::ok);
  Head head;
  head.content_length = 5;
  Body body(connection, head, 1000, std::chrono::milliseconds(300));
  body.discard_arrived();
  CHECK(body.consumed());
  CHECK(connection.buffered() == "NEXT");

  Body lacking(connection, head, 1000, std::chrono::milliseconds(300));
  lacking.discard_arrived();
  CHECK(!lacking.consumed());
  CHECK(connection.buffered() == "NEXT");

  head.content_length.reset();
  head.chunked = true;
  Body in_chunks(connection, head, 1000, std::chrono::milliseconds(300));
  in_chunks.discard_arrived();
  CHECK(!in_chunks.consumed());
  for (const int end : ends) ::close(end);
}
