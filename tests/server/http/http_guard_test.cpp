// The guard between clients and handlers: responses that fail, requests at shutdown, clients that take their time.
#include "server/http/http_guard.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <openssl/bio.h>
#include <openssl/ssl.h>

#include <doctest/doctest.h>

#include "api/base/descriptor.h"
#include "server/http/tls.h"
#include "server/main/checked.h"
#include "tests/eventually.h"
#include "tests/server/http/certificate_files.h"

using namespace meshgauge::server;
using meshgauge::Descriptor;
using meshgauge::eventually;
using namespace std::chrono_literals;

namespace {

Settings guard_settings() {
  Settings settings;
  settings.port = 0;
  settings.workers = settings.queue = 1;
  settings.head_timeout_ms = settings.body_timeout_ms = settings.keep_alive_ms = 600'000;
  return checked(settings).value();
}

// Handles every request by the functions of a test.
class GivenHandler final : public RequestHandler {
 public:
  using Handle = std::function<void(Exchange&)>;
  using Log = std::function<void(const Exchange&)>;

  GivenHandler(Handle handles, Log logs) : handles_(std::move(handles)), logs_(std::move(logs)) {}

  Entry enter(Exchange&) override { return Entry::handled; }
  void handle(Exchange& exchange) override { handles_(exchange); }
  void log(const Exchange& exchange) override { logs_(exchange); }

 private:
  const Handle handles_;
  const Log logs_;
};

// A server on its own threads for the lifetime of the object.
class Guarded {
 public:
  explicit Guarded(
      GivenHandler::Handle handle, GivenHandler::Log log = [](const Exchange&) {},
      const Settings& chosen = guard_settings(), const Tls* tls = nullptr, std::chrono::milliseconds write_time = 30s)
      : handler(std::move(handle), std::move(log)),
        guard(chosen, handler, tls, 1000, write_time),
        port_(guard.bind().value()) {
    listener_ = std::thread([this] { guard.run(); });
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

  GivenHandler handler;
  HttpGuard guard;

 private:
  const int port_;
  std::thread listener_;
};

class RawClient {
 public:
  // `room`: bytes that the kernel takes for it while it does not read; 0: as usual.
  explicit RawClient(int port, int room = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (room > 0) ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    REQUIRE(::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }

  int fd() const { return socket_.get(); }
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
  std::string read_head() const { return read_to("\r\n\r\n"); }
  // Reads what has arrived, or waits for more. False: the other side has closed.
  bool read_some() const {
    std::vector<char> bytes(1 << 16);
    return ::recv(socket_.get(), bytes.data(), bytes.size(), 0) > 0;
  }
  bool is_open() const {
    char byte = 0;
    return ::recv(socket_.get(), &byte, 1, MSG_DONTWAIT | MSG_PEEK) != 0;
  }
  // Sends until the other side closes. Returns how many bytes it took.
  std::size_t flood() const {
    const std::vector<char> bytes(1 << 16, 'x');
    std::size_t sent = 0;
    for (;;) {
      const ssize_t n = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return sent;
      sent += static_cast<std::size_t>(n);
    }
  }

 private:
  const Descriptor socket_;
};

// A client that has shaken hands. What it writes from then on waits for send().
class TlsClient {
 public:
  explicit TlsClient(int port)
      : raw_(port), context_(SSL_CTX_new(TLS_client_method()), SSL_CTX_free), ssl_(SSL_new(context_.get()), SSL_free) {
    REQUIRE(SSL_set_fd(ssl_.get(), raw_.fd()) == 1);
    REQUIRE(SSL_connect(ssl_.get()) == 1);
    SSL_set0_wbio(ssl_.get(), BIO_new(BIO_s_mem()));
  }

  void write(char byte) const { REQUIRE(SSL_write(ssl_.get(), &byte, 1) == 1); }
  void update_keys() const {
    REQUIRE(SSL_key_update(ssl_.get(), SSL_KEY_UPDATE_NOT_REQUESTED) == 1);
    REQUIRE(SSL_do_handshake(ssl_.get()) == 1);
  }
  void send() const {
    char* data = nullptr;
    const auto size = BIO_get_mem_data(SSL_get_wbio(ssl_.get()), &data);
    raw_.send(std::string(data, static_cast<std::size_t>(size)));
  }

 private:
  const RawClient raw_;
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context_;
  const std::unique_ptr<SSL, decltype(&SSL_free)> ssl_;
};

Settings of_one_thread() {
  Settings one = guard_settings();
  one.io_threads = 1;
  one.max_arriving_per_peer = 1000;
  return one;
}

constexpr const char* kGet = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";

// Answers with the response's path, when it is told to.
struct Held {
  std::atomic<bool> released{false};
  std::atomic<int> waiting{0};
  std::mutex mutex;
  std::vector<std::function<void()>> wakes;

  void hold(Exchange& exchange) {
    {
      const std::lock_guard lock(mutex);
      wakes.push_back(exchange.wake);
    }
    ++waiting;
  }
  void release() {
    released = true;
    const std::lock_guard lock(mutex);
    for (const auto& wake : wakes) wake();
  }
};

std::optional<Clock::time_point> never() { return Clock::now() + 600s; }

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("guard: which hosts stand for this machine alone") {
  for (const char* host : {"127.0.0.1", "127.8.0.1", "::1", "::ffff:127.0.0.1", "localhost"})
    CHECK_MESSAGE(stands_for_loopback(host), host);
  for (const char* host : {"0.0.0.0", "::", "192.0.2.1", "2001:db8::1", "::ffff:192.0.2.1"})
    CHECK_MESSAGE(!stands_for_loopback(host), host);
  CHECK(stands_for_loopback("no such host"));  // which cannot be bound either
}

TEST_CASE("guard: a problem releases the stream or file that was started before it") {
  const auto holder = std::make_shared<int>(0);
  std::atomic<long> held{-1};
  std::function<void(Response&)> begin;
  std::string method = "GET";
  SUBCASE("a stream") {
    begin = [&](Response& response) {
      response.stream = [holder](std::string& piece) {
        piece = "begun";
        return std::optional<Clock::time_point>();
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
      [&](const Exchange&) { held = holder.use_count() - 1; });
  const RawClient client(guarded.port());
  client.send(method + " / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string answer = client.read_to_end();
  CHECK(answer.starts_with("HTTP/1.1 500 "));
  CHECK(has(answer, "\r\nContent-Type: application/problem+json\r\n"));
  CHECK(has(answer, "\r\nContent-Length: "));
  CHECK(has(answer, "/problems/internal") == (method == "GET"));
  CHECK_FALSE(has(answer, "begun"));
  CHECK(held == 0);
}

TEST_CASE("guard: a request that is arriving at shutdown gets shutting-down, not a time-out") {
  std::atomic<bool> begun{false};
  Guarded guarded([&](Exchange& exchange) {
    begun = true;
    exchange.body.read([](auto) { return Body::Refusal(); },
                       [&](const Body::Refusal& refusal) {
                         if (refusal) answer(exchange, *refusal);
                       });
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
  CHECK(has(answer, "/problems/shutting-down"));
  CHECK(has(answer, "the service shut down before the " + what + " had arrived"));
  CHECK(has(answer, "\r\nRetry-After: 1\r\n"));
}

TEST_CASE("guard: clients that send slowly, wait, listen or are idle hold no thread") {
  Held held;
  Guarded guarded(
      [&](Exchange& exchange) {
        if (exchange.head.path == "/body") {
          exchange.body.read([](auto) { return Body::Refusal(); }, [](const Body::Refusal&) {});
        } else if (exchange.head.path == "/wait") {
          held.hold(exchange);
          exchange.response.later = [&](Exchange& later) {
            later.response.body = "made";
            return held.released ? std::nullopt : never();
          };
        } else if (exchange.head.path == "/listen") {
          held.hold(exchange);
          exchange.response.stream = [&](std::string& piece) {
            if (held.released) piece = "made";
            return held.released ? std::nullopt : never();
          };
        }
      },
      [](const Exchange&) {}, of_one_thread());
  std::list<RawClient> slow, uploading, waiting, idle;
  for (int i = 0; i < 20; ++i) {
    slow.emplace_back(guarded.port()).send("GET / HT");
    uploading.emplace_back(guarded.port()).send("POST /body HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\n\r\nhe");
    waiting.emplace_back(guarded.port())
        .send(std::string("GET ") + (i % 2 ? "/wait" : "/listen") + " HTTP/1.1\r\nHost: x\r\n\r\n");
    idle.emplace_back(guarded.port()).send(kGet);
    CHECK(idle.back().read_head().starts_with("HTTP/1.1 200 "));
  }
  REQUIRE(eventually([&] { return held.waiting == 20; }));
  held.release();
  for (const RawClient& client : waiting) CHECK(has(client.read_to("made"), "HTTP/1.1 200 "));
  for (const RawClient& client : idle) {
    client.send(kGet);
    CHECK(client.read_head().starts_with("HTTP/1.1 200 "));
  }
  for (const RawClient& client : uploading) {
    client.send("llo");
    CHECK(client.read_head().starts_with("HTTP/1.1 200 "));
  }
  for (const RawClient& client : slow) {
    client.send("TP/1.1\r\nHost: x\r\n\r\n");
    CHECK(client.read_head().starts_with("HTTP/1.1 200 "));
  }
}

TEST_CASE("guard: a head with updates of keys between its bytes is read in turns with other clients") {
  const CertificateFiles files;
  Tls tls(files.certificate_file(), files.key_file());
  REQUIRE(tls.reload().ok());
  std::atomic<bool> held{false}, released{false};
  std::mutex mutex;
  std::string order;
  const auto handle = [&](Exchange& exchange) {
    if (exchange.head.path == "/hold") {
      exchange.response.quick = true;
      exchange.response.later = [&, asked = 0](const Exchange&) mutable {
        if (++asked == 1) return std::optional(Clock::now());
        held = true;  // the loop, since this is quick
        while (!released) std::this_thread::sleep_for(1ms);
        return std::optional<Clock::time_point>();
      };
      return;
    }
    const std::lock_guard lock(mutex);
    order += exchange.head.path;
  };
  const Guarded guarded(
      handle, [](const Exchange&) {}, of_one_thread(), &tls);
  const TlsClient updating(guarded.port()), other(guarded.port()), holding(guarded.port());
  for (const char byte : "GET /updating HTTP/1.1\r\nHost: x\r\nX: " + std::string(1000, 'x') + "\r\n\r\n") {
    updating.write(byte);
    updating.update_keys();
  }
  for (const char byte : std::string("GET /other HTTP/1.1\r\nHost: x\r\n\r\n")) other.write(byte);
  for (const char byte : std::string("GET /hold HTTP/1.1\r\nHost: x\r\n\r\n")) holding.write(byte);
  holding.send();
  REQUIRE(eventually([&] { return held.load(); }));
  updating.send();
  other.send();
  released = true;
  CHECK(eventually([&] {
    const std::lock_guard lock(mutex);
    return order == "/other/updating";
  }));
}

TEST_CASE("guard: a response that waits is told that its client has gone") {
  std::atomic<bool> gone{false};
  const Guarded guarded([&](Exchange& exchange) {
    exchange.response.later = [&](const Exchange& later) {
      gone = later.client_gone;
      return gone ? std::nullopt : never();
    };
  });
  { RawClient(guarded.port()).send(kGet); }
  CHECK(eventually([&] { return gone.load(); }));
  CHECK(eventually([&] { return guarded.guard.connections() == 0; }));
}

TEST_CASE("guard: a response that waits is asked again at its time") {
  std::atomic<int> asked{0};
  const Guarded guarded([&](Exchange& exchange) {
    exchange.response.later = [&](const Exchange&) {
      return ++asked < 3 ? std::optional(Clock::now() + 1ms) : std::nullopt;
    };
  });
  const RawClient client(guarded.port());
  client.send(kGet);
  CHECK(client.read_head().starts_with("HTTP/1.1 200 "));
  CHECK(asked == 3);
}

TEST_CASE("guard: a wake-up that comes before the response waits is kept") {
  std::atomic<int> asked{0};
  const Guarded guarded([&](Exchange& exchange) {
    exchange.response.later = [&](const Exchange&) { return ++asked < 2 ? std::optional(never()) : std::nullopt; };
    exchange.wake();
  });
  const RawClient client(guarded.port());
  client.send(kGet);
  CHECK(client.read_head().starts_with("HTTP/1.1 200 "));
  CHECK(asked == 2);
}

TEST_CASE("guard: a stream that is never read is ended, though the kernel takes more, and one that is read goes on") {
  std::atomic<int> ended{0};
  const auto stream = [](Exchange& exchange) {
    exchange.response.quick = true;
    exchange.response.stream = [](std::string& piece) {
      piece = std::string(1000, 'x');
      return std::optional(Clock::now() + 10ms);
    };
  };
  const auto count = [&](const Exchange& exchange) { ended += exchange.delivered ? 100 : 1; };
  const Guarded guarded(stream, count, guard_settings(), nullptr, 1s);
  const RawClient reader(guarded.port()), sleeper(guarded.port(), 4096);
  reader.send(kGet);
  sleeper.send(kGet);
  std::atomic<bool> over{false};
  std::thread reading([&] {
    while (!over && reader.read_some()) continue;
  });
  CHECK(eventually([&] { return ended != 0; }));
  over = true;
  reading.join();
  CHECK(ended == 1);
  CHECK(reader.is_open());
}

TEST_CASE("guard: a stream that begins late is not taken for one that stands still since its request") {
  std::atomic<int> pieces{0};
  const auto handle = [&](Exchange& exchange) {
    if (exchange.head.path == "/before") {
      exchange.response.body = std::string(12'000, 'x');  // more than the client takes
      return;
    }
    exchange.response.later = [due = Clock::now() + 1500ms](const Exchange&) {
      return Clock::now() < due ? std::optional(due) : std::nullopt;
    };
    exchange.response.stream = [&](std::string&) {
      ++pieces;
      return never();
    };
  };
  const Guarded guarded(
      handle, [](const Exchange&) {}, guard_settings(), nullptr, 1s);
  const RawClient client(guarded.port(), 4096);
  client.send("GET /before HTTP/1.1\r\nHost: x\r\n\r\n" + std::string(kGet));
  CHECK(eventually([&] { return pieces > 0; }));
}

TEST_CASE("guard: the rest of a body that was refused for now is discarded, and the connection goes on") {
  const Guarded guarded([](Exchange& exchange) {
    if (exchange.head.method == "POST") {
      answer(exchange, meshgauge::api::Problem{meshgauge::api::ProblemKind::overloaded, "later", {}});
    }
  });
  const RawClient client(guarded.port());
  const std::string head = "POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n\r\n";
  for (int i = 0; i < 2; ++i) {
    client.send(head + std::string(1'000'000, 'x') + kGet);
    CHECK_FALSE(has(client.read_head(), "Connection: close"));
    CHECK(client.read_to("HTTP/1.1 200 OK").ends_with("}HTTP/1.1 200 OK"));
    client.read_head();
  }
  client.send("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\nExpect: 100-continue\r\n\r\n");
  CHECK(has(client.read_head(), "Connection: close"));  // the body may come or not
}

TEST_CASE("guard: a client that has sent unread bytes gets its response, one that sends without end is dropped") {
  const Guarded guarded([](Exchange& exchange) {
    answer(exchange, meshgauge::api::Problem{meshgauge::api::ProblemKind::malformed_request, "no", {}});
  });
  const std::string head = "POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 100000000\r\n\r\n";
  {
    const RawClient client(guarded.port());
    client.send(head + std::string(1'000'000, 'x'));  // closing now would reset the connection
    CHECK(client.read_to_end().starts_with("HTTP/1.1 400 "));
  }
  const RawClient flooding(guarded.port());
  flooding.send(head);
  CHECK(flooding.flood() < std::size_t{64} << 20);  // 16 MiB, and what the kernel's buffers take
  const RawClient staying(guarded.port());
  staying.send(head);
  CHECK(staying.read_to_end().starts_with("HTTP/1.1 400 "));
  CHECK(eventually([&] { return guarded.guard.connections() == 0; }));
}

TEST_CASE("guard: no connection is left after stop() and abort()") {
  Guarded guarded([](Exchange& exchange) { exchange.response.later = [](Exchange&) { return never(); }; });
  const RawClient idle(guarded.port()), late(guarded.port());
  CHECK(eventually([&] { return guarded.guard.connections() == 2; }));
  late.send("GET / HT");
  guarded.end();
  CHECK(idle.read_to_end().empty());
  CHECK(eventually([&] { return guarded.guard.connections() == 0; }));
}

TEST_CASE("guard: when no thread is left, requests are refused, and their connections stay") {
  std::atomic<bool> busy{false}, released{false};
  Settings one = of_one_thread();
  one.max_pending_connections = 0;
  Guarded guarded(
      [&](Exchange&) {
        busy = true;
        while (!released) std::this_thread::sleep_for(1ms);
      },
      [](const Exchange&) {}, one);
  const RawClient first(guarded.port());
  first.send(kGet);
  REQUIRE(eventually([&] { return busy.load(); }));
  const RawClient second(guarded.port());
  second.send(kGet);
  const std::string refusal = second.read_to("\r\n\r\n");
  CHECK(refusal.starts_with("HTTP/1.1 503 "));
  CHECK_FALSE(has(refusal, "Connection: close"));
  released = true;
  CHECK(first.read_head().starts_with("HTTP/1.1 200 "));
}
