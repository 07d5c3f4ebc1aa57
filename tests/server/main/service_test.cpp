// The service with a stand-in for the readers: queue, limits and disconnects.
#include "server/main/service.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <atomic>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "server/http/http_library.h"
#include "server/main/checked.h"
#include "tests/eventually.h"
#include "tests/server/stand_in.h"
#include "tests/server/store/implementations.h"

using namespace meshgauge;
using nlohmann::json;
using server::Service;
using server::Settings;

namespace {

Settings small() {
  Settings settings;
  settings.port = 0;
  settings.workers = 1;
  settings.queue = 1;
  settings.io_threads = 8;
  settings.max_event_streams = 4;
  settings.max_part_bytes = 1000;
  settings.max_request_bytes = 3000;
  return server::checked(settings).value();
}

struct KeptStores {
  server::store::EmbeddedForTests embedded;
  server::MeshCache cache{std::uint64_t{1} << 20};

  server::Stores stores() { return {embedded.jobs(), embedded.meshes(), embedded.blobs(), embedded.signals(), cache}; }
};

// A load that blocks until it is released or cancelled, and counts its calls.
struct Stub final : server::MeshLoader {
  std::atomic<int> running{0};
  std::atomic<int> cancelled{0};
  std::atomic<bool> released{false};

  Result<api::SharedMesh> load(const server::MeshSource& source, server::MemoryReservation&,
                               Control& control) override {
    if (source.input.part == "b") return server::stand_in(source);
    ++running;
    while (!released && control.check() == Interruption::none)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    cancelled += control.check() == Interruption::cancelled;
    return server::stand_in(source);
  }
};

struct Throws final : server::MeshLoader {
  Result<api::SharedMesh> load(const server::MeshSource&, server::MemoryReservation&, Control&) override {
    throw std::runtime_error("secret path");
  }
};

httplib::MultipartFormDataItems form(const std::string& a = "mesh a", const std::string& options = "{}") {
  return {{"a", a, "a.obj", ""}, {"b", "mesh b", "b.obj", ""}, {"options", options, "", "application/json"}};
}

httplib::Result post(int port, const httplib::MultipartFormDataItems& items = form()) {
  httplib::Client client("127.0.0.1", port);
  return client.Post("/v1/comparisons", items);
}

// Makes accept() fail for good, with EINVAL.
void break_listener(int port) {
  for (int fd = 0; fd < 1024; ++fd) {
    int accepts = 0;
    socklen_t size = sizeof accepts;
    sockaddr_in address{};
    socklen_t address_size = sizeof address;
    if (::getsockopt(fd, SOL_SOCKET, SO_ACCEPTCONN, &accepts, &size) != 0 || accepts == 0) continue;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &address_size) != 0) continue;
    if (ntohs(address.sin_port) == port) ::shutdown(fd, SHUT_RDWR);
  }
}

}  // namespace

TEST_CASE("service: the response describes the meshes compared") {
  Stub stub;
  stub.released = true;
  KeptStores kept;
  Service service(small(), stub, kept.stores());
  const int port = service.start().value();
  const auto response = post(port, form("0123456789", R"({"gate": {"max_distance": 1, "units": "mm"}})"));
  REQUIRE(response);
  CHECK(response->status == 200);
  const json result = json::parse(response->body);
  CHECK(result["meshes"]["a"]["bytes"] == 10);
  CHECK(result["gate"]["units"] == "mm");
  CHECK(result["id"] == response->get_header_value("X-Request-Id"));
  CHECK(response->get_header_value("Server-Timing").starts_with("queue;dur="));
}

TEST_CASE("service: a full queue answers 503 at once, and admitted requests are served") {
  Stub stub;
  KeptStores kept;
  Service service(small(), stub, kept.stores());
  const int port = service.start().value();
  std::atomic<int> refused{0};
  std::vector<std::future<int>> clients;
  clients.reserve(6);
  for (int i = 0; i < 6; ++i) {
    clients.push_back(std::async(std::launch::async, [&] {
      const auto response = post(port);
      const bool polite = response->has_header("Retry-After") &&
                          response->get_header_value("Content-Type") == "application/problem+json";
      refused += response->status == 503 && polite;
      return response->status;
    }));
  }
  // One runs, one waits; neither ends before the others are refused.
  CHECK(eventually([&] { return refused == 4; }));
  stub.released = true;
  int served = 0;
  for (auto& client : clients) served += client.get() == 200;
  CHECK(served == 2);
  CHECK(post(port)->status == 200);
}

TEST_CASE("service: clients that repeat an Idempotency-Key wait for the same job, up to the limit") {
  Stub stub;
  KeptStores kept;
  Settings settings = small();
  settings.max_event_streams = 1;
  Service service(settings, stub, kept.stores());
  const int port = service.start().value();
  std::atomic<int> refused{0};
  const auto repeat = [&] {
    httplib::Client client("127.0.0.1", port);
    client.set_read_timeout(100);
    const auto response = client.Post("/v1/comparisons", {{"Idempotency-Key", "one"}}, form());
    refused += response->status == 503;
    return response->status == 200 ? json::parse(response->body)["id"].get<std::string>() : "";
  };
  auto first = std::async(std::launch::async, repeat);
  REQUIRE(eventually([&] { return stub.running == 1; }));
  std::vector<std::future<std::string>> others;
  for (int i = 0; i < 3; ++i) others.push_back(std::async(std::launch::async, repeat));
  CHECK(eventually([&] { return refused == 2; }));
  stub.released = true;
  const std::string id = first.get();
  int same = 0;
  for (auto& other : others) same += other.get() == id;
  CHECK(same == 1);
  CHECK(stub.running == 1);
  CHECK(repeat() == id);
}

TEST_CASE("service: health is answered while every worker is busy") {
  Stub stub;
  KeptStores kept;
  Service service(small(), stub, kept.stores());
  const int port = service.start().value();
  auto busy = std::async(std::launch::async, [port] { return post(port)->status; });
  REQUIRE(eventually([&] { return stub.running == 1; }));
  httplib::Client client("127.0.0.1", port);
  CHECK(client.Get("/healthz")->status == 200);
  stub.released = true;
  CHECK(busy.get() == 200);
}

TEST_CASE("service: one client has all places, Retry-After is what they need, and others are still served") {
  Stub stub;
  Settings settings = small();
  settings.queue = 3;
  KeptStores kept;
  Service service(settings, stub, kept.stores());
  const int port = service.start().value();
  httplib::Client client("127.0.0.1", port);
  std::vector<std::future<int>> answers;
  for (int i = 0; i < 4; ++i) answers.push_back(std::async(std::launch::async, [port] { return post(port)->status; }));
  REQUIRE(eventually(
      [&] { return client.Get("/metrics")->body.find("\nmeshgauge_queue_depth 3\n") != std::string::npos; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(550));
  const auto refused = post(port);
  CHECK(refused->status == 503);
  CHECK(std::stoi(refused->get_header_value("Retry-After")) >= 3);  // 0.55 s for each of four, rounded up
  CHECK(client.Get("/readyz")->status == 200);
  answers.push_back(std::async(std::launch::async, [port] {
    httplib::Client other("127.0.0.1", port);
    other.set_interface("127.0.0.2");
    return other.Post("/v1/comparisons", form())->status;
  }));
  REQUIRE(eventually([&] { return stub.running == 2; }));
  CHECK(client.Get("/readyz")->status == 503);
  stub.released = true;
  for (auto& answer : answers) CHECK(answer.get() == 200);
}

TEST_CASE("service: a client that disconnects cancels its job") {
  Stub stub;
  KeptStores kept;
  Service service(small(), stub, kept.stores());
  const int port = service.start().value();
  {
    httplib::Client client("127.0.0.1", port);
    client.set_read_timeout(0, 200'000);
    CHECK(!client.Post("/v1/comparisons", form()));
  }
  CHECK(eventually([&] { return stub.cancelled == 1; }));
  stub.released = true;
  CHECK(post(port)->status == 200);
}

TEST_CASE("service: limits of a part, of the options and of all uploads") {
  Stub stub;
  stub.released = true;
  Settings settings = small();
  settings.max_upload_bytes = 500;
  KeptStores kept;
  Service service(settings, stub, kept.stores());
  const int port = service.start().value();
  CHECK(post(port, form(std::string(1001, 'x')))->status == 413);
  CHECK(post(port, form(std::string(3001, 'x')))->status == 413);
  CHECK(post(port, form(std::string(900, 'x')))->status == 503);
  CHECK(post(port, form(std::string(100, 'x')))->status == 200);
  CHECK(post(port, form("x", R"({"unknown": 1})"))->status == 422);
}

TEST_CASE("service: a comparison gets the threads that are idle, and the operator's instruction set") {
  Stub stub;
  Settings settings = small();
  settings.workers = 3;
  settings.queue = 0;
  settings.simd = "scalar";
  KeptStores kept;
  Service service(settings, stub, kept.stores());
  const int port = service.start().value();
  const auto engine = [port](const std::string& options) {
    return json::parse(post(port, form("mesh a", options))->body)["engine"];
  };
  auto first = std::async(std::launch::async, [&] { return engine(R"({"threads": 2})"); });
  REQUIRE(eventually([&] { return stub.running == 1; }));
  auto second = std::async(std::launch::async, [&] { return engine(R"({"threads": 64})"); });
  REQUIRE(eventually([&] { return stub.running == 2; }));
  auto third = std::async(std::launch::async, [&] { return engine(R"({"threads": 64})"); });
  REQUIRE(eventually([&] { return stub.running == 3; }));
  stub.released = true;
  const json first_engine = first.get();
  CHECK(first_engine["threads"] == 2);
  CHECK(first_engine["simd"] == "scalar");
  CHECK(second.get()["threads"] == 1);  // the last idle one
  CHECK(third.get()["threads"] == 1);   // its own worker's
  CHECK(engine(R"({"threads": 64})")["threads"] == 3);
  CHECK(engine("{}")["threads"] == 1);
}

TEST_CASE("service: parts are a, b and options, each once") {
  Stub stub;
  stub.released = true;
  KeptStores kept;
  Service service(small(), stub, kept.stores());
  const int port = service.start().value();
  const auto detail = [&](const httplib::MultipartFormDataItems& items) {
    const auto response = post(port, items);
    CHECK(response->status == 400);
    return json::parse(response->body)["detail"].get<std::string>();
  };
  CHECK(detail({{"a", "x", "", ""}}) == "the part 'b' is missing; the form holds 'a'");
  CHECK(detail({{"b", "x", "", ""}}) == "the part 'a' is missing; the form holds 'b'");
  CHECK(detail({{"a", "x", "", ""}, {"a", "x", "", ""}}) == "the part 'a' was sent twice");
  CHECK(detail({{"a", "x", "", ""}, {"c", "x", "", ""}}).starts_with("unknown part 'c'"));
  CHECK(detail({{"options", "{}", "", ""}, {"options", "{}", "", ""}}) == "the part 'options' was sent twice");
  CHECK(post(port, {{"b", "x", "", ""}, {"a", "x", "", ""}})->status == 200);
}

TEST_CASE("service: the text of an exception is not sent") {
  KeptStores kept;
  Throws throwing;
  Service service(small(), throwing, kept.stores());
  const int port = service.start().value();
  const auto response = post(port);
  CHECK(response->status == 500);
  CHECK(response->body.find("secret") == std::string::npos);
  CHECK(json::parse(response->body)["type"] == "/problems/internal");
  CHECK(post(port)->status == 500);
}

TEST_CASE("service: shutdown cancels running requests and answers them") {
  Stub stub;
  KeptStores kept;
  auto service = std::make_unique<Service>(small(), stub, kept.stores());
  const int port = service->start().value();
  auto running = std::async(std::launch::async, [port] { return post(port)->status; });
  REQUIRE(eventually([&] { return stub.running == 1; }));
  service.reset();
  CHECK(running.get() == 200);
  CHECK(stub.cancelled == 1);
  CHECK(!post(port));
}

TEST_CASE("service: a listening socket that fails is noticed while clients keep every thread busy") {
  Stub stub;
  KeptStores kept;
  Service service(small(), stub, kept.stores());
  const int port = service.start().value();
  httplib::Client steady("127.0.0.1", port);
  steady.set_keep_alive(true);
  REQUIRE(steady.Get("/healthz"));
  auto running = std::async(std::launch::async, [port] { return post(port)->status; });
  REQUIRE(eventually([&] { return stub.running == 1; }));
  REQUIRE(service.listening());
  break_listener(port);
  CHECK(eventually([&] { return !service.listening(); }));
  service.shutdown([] { return true; });
  CHECK(running.get() == 200);
  CHECK(!post(port));
}

TEST_CASE("service: an address in use is an error") {
  Stub stub;
  KeptStores kept;
  Service first(small(), stub, kept.stores());
  Settings settings = small();
  settings.port = static_cast<std::uint64_t>(first.start().value());
  Service second(settings, stub, kept.stores());
  CHECK(!second.start().ok());
}
