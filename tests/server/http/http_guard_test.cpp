// The guard between clients and handlers: responses that fail, and requests at shutdown.
#include "server/http/http_guard.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <doctest/doctest.h>

using namespace meshgauge::server;
using namespace std::chrono_literals;

namespace {

Settings settings() {
  Settings settings;
  settings.port = 0;
  settings.workers = settings.queue = 1;
  settings.head_timeout_ms = settings.body_timeout_ms = settings.keep_alive_ms = 600'000;
  return checked(settings).value();
}

// A server on its own threads for the lifetime of the object.
class Guarded {
 public:
  explicit Guarded(
      HttpGuard::Handler handle, HttpGuard::Handler log = [](Exchange&) {})
      : guard(settings(), std::move(handle), std::move(log), nullptr), port_(guard.bind().value()) {
    listener_ = std::thread([this] { guard.run(); });
    while (!guard.running()) std::this_thread::sleep_for(1ms);
  }
  ~Guarded() {
    end();
    listener_.join();
  }
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;

  void end() {
    guard.stop();
    guard.abort();
  }
  int port() const { return port_; }

  HttpGuard guard;

 private:
  const int port_;
  std::thread listener_;
};

class RawClient {
 public:
  explicit RawClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    REQUIRE(::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }

  void send(const std::string& bytes) const {
    REQUIRE(::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size()));
  }
  // Reads up to `last` or the end.
  std::string read_to(const std::string& last) const {
    std::string all;
    char byte = 0;
    while (!all.ends_with(last) && ::recv(socket_.get(), &byte, 1, 0) == 1) all += byte;
    return all;
  }
  std::string read_to_end() const { return read_to("no answer ends like this"); }

 private:
  const Descriptor socket_;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("guard: a problem releases the stream or file that was started before it") {
  const auto holder = std::make_shared<int>(0);
  std::atomic<long> held{-1};
  std::function<void(Response&)> begin;
  std::string method = "GET";
  SUBCASE("a stream") {
    begin = [&](Response& response) {
      response.stream = [holder](std::string& piece) {
        piece = "begun";
        return false;
      };
    };
  }
  SUBCASE("a file") {
    begin = [&](Response& response) { response.file = FileBody{std::as_bytes(std::span("begun", 5)), holder}; };
  }
  SUBCASE("an answer to HEAD without a length") {
    method = "HEAD";
    begin = [&](Response& response) { response.length_known = false; };
  }
  const Guarded guarded(
      [&](Exchange& exchange) {
        begin(exchange.response);
        throw std::runtime_error("no memory for a header");
      },
      [&](Exchange&) { held = holder.use_count() - 1; });
  const RawClient client(guarded.port());
  client.send(method + " / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string answer = client.read_to_end();
  CHECK(answer.starts_with("HTTP/1.1 500 "));
  CHECK(has(answer, "\r\nContent-Type: application/problem+json\r\n"));
  CHECK(has(answer, "\r\nContent-Length: "));
  CHECK(has(answer, "urn:meshgauge:problem:internal") == (method == "GET"));
  CHECK_FALSE(has(answer, "begun"));
  CHECK(held == 0);
}

TEST_CASE("guard: a request that is arriving at shutdown gets shutting-down, not a time-out") {
  std::atomic<bool> begun{false};
  Guarded guarded([&](Exchange& exchange) {
    begun = true;
    if (auto refusal = exchange.body.read([](auto) { return Body::Refusal(); })) answer(exchange, *refusal);
  });
  const RawClient client(guarded.port());
  std::string what;
  SUBCASE("a body") {
    client.send("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\n\r\nhalf");
    what = "body";
  }
  SUBCASE("a body in chunks") {
    client.send("POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n4\r\nha");
    what = "body";
  }
  SUBCASE("a head") {  // after a request, else a connection where nothing has arrived yet is closed
    client.send("GET / HTTP/1.1\r\nHost: x\r\n\r\nGET / HT");
    CHECK(client.read_to("\r\n\r\n").starts_with("HTTP/1.1 200 "));
    what = "head";
  }
  while (!begun) std::this_thread::sleep_for(1ms);
  guarded.end();
  const std::string answer = client.read_to_end();
  CHECK(answer.starts_with("HTTP/1.1 503 "));
  CHECK(has(answer, "urn:meshgauge:problem:shutting-down"));
  CHECK(has(answer, "the service shut down before the " + what + " had arrived"));
  CHECK(has(answer, "\r\nRetry-After: 1\r\n"));
}
