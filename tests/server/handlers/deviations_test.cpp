// Deviation maps of the service: the order of concurrent requests.
#include <atomic>
#include <future>
#include <memory>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "server/http/http_library.h"
#include "server/main/checked.h"
#include "server/main/service.h"
#include "server/main/wiring.h"
#include "tests/server/store/implementations.h"

using namespace meshgauge;
using server::Service;
using server::Settings;
namespace store = server::store;

namespace {

// While `armed`, the next call that opens a blob blocks until it is released.
class PausingBlobs : public store::BlobStore {
 public:
  explicit PausingBlobs(store::BlobStore& real) : real_(real) {}

  Result<std::optional<store::Blob>> open(const store::BlobKey& key) override {
    if (armed.exchange(false)) {
      paused = true;
      released.wait(false);
    }
    return real_.open(key);
  }
  Result<store::BlobPut> put(const store::BlobKey& key, std::span<const std::byte> bytes) override {
    return real_.put(key, bytes);
  }
  Result<bool> exists(const store::BlobKey& key) override { return real_.exists(key); }
  Result<bool> renew(const store::BlobKey& key) override { return real_.renew(key); }
  Result<bool> remove(const store::BlobKey& key) override { return real_.remove(key); }
  Result<store::UnusedBlobs> count_unused(std::span<const store::BlobKey> used, std::chrono::seconds older) override {
    return real_.count_unused(used, older);
  }
  Result<std::uint64_t> remove_unused(std::span<const store::BlobKey> used, std::chrono::seconds older) override {
    return real_.remove_unused(used, older);
  }
  Result<std::uint64_t> stored_bytes(const std::string& owner) override { return real_.stored_bytes(owner); }
  Result<std::uint64_t> free_bytes() override { return real_.free_bytes(); }
  Result<Done> check() override { return real_.check(); }

  std::atomic<bool> armed{false}, paused{false}, released{false};

 private:
  store::BlobStore& real_;
};

struct LoadsHere final : server::MeshLoader {
  Result<api::SharedMesh> load(const server::MeshSource& source, server::MemoryReservation&,
                               Control& control) override {
    return api::prepare(api::load(source.input, {}), source.input, Prepared::Use::once, control);
  }
};

Settings deviation_settings() {
  Settings settings;
  settings.port = 0;
  settings.workers = 1;
  return server::checked(settings).value();
}

std::string stored(httplib::Client client, const std::string& obj) {
  const auto answer = client.Post("/v1/meshes", obj, "model/obj");
  REQUIRE(answer);
  REQUIRE(answer->status == 201);
  return nlohmann::json::parse(answer->body)["id"];
}

// A service with one comparison, and a client whose request for its map is blocked at opening the first mesh.
struct HeldUp {
  HeldUp() {
    REQUIRE(maps.open().ok());
    port = service.start().value();
    a = stored(client(), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string b = stored(client(), "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n");
    const auto compared =
        client().Post("/v1/comparisons", nlohmann::json{{"a", a}, {"b", b}}.dump(), "application/json");
    REQUIRE(compared);
    REQUIRE(compared->status == 200);
    comparison = "/v1/comparisons/" + nlohmann::json::parse(compared->body)["id"].get<std::string>();
    blobs.armed = true;
    late_ = std::async(std::launch::async, [this] { return map(); });
    while (!blobs.paused) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~HeldUp() { release(); }

  httplib::Client client() const { return httplib::Client("127.0.0.1", port); }
  httplib::Result map() const { return client().Get(comparison + "/deviation.ply"); }
  httplib::Result late() {
    release();
    return late_.get();
  }

  store::EmbeddedForTests embedded;
  PausingBlobs blobs{embedded.blobs()};
  server::MeshCache cache{std::uint64_t{1} << 20};
  server::MapCache maps{{embedded.folder() / "maps", 1'000'000, "/tmp"}};
  LoadsHere loader;
  Service service{deviation_settings(),
                  loader,
                  {embedded.jobs(), embedded.meshes(), blobs, embedded.signals(), cache, false, &maps}};
  int port = 0;
  std::string a, comparison;

 private:
  void release() {
    blobs.released = true;
    blobs.released.notify_all();
  }

  std::future<httplib::Result> late_;
};

}  // namespace

TEST_CASE("deviations: a request that missed the cache gets the map that was made meanwhile") {
  HeldUp held;
  const auto first = held.map();
  const auto second = held.late();
  REQUIRE(first);
  REQUIRE(second);
  CHECK(first->status == 200);
  CHECK(first->get_header_value("Server-Timing").starts_with("queue;dur="));
  CHECK(second->status == 200);
  CHECK(second->get_header_value("Server-Timing") == "cached");
  CHECK(second->body == first->body);
  const auto metrics = held.client().Get("/metrics");
  REQUIRE(metrics);
  CHECK(metrics->body.find("meshgauge_maps_total{outcome=\"made\"} 1\n") != std::string::npos);
  CHECK(metrics->body.find("meshgauge_maps_total{outcome=\"cached\"} 1\n") != std::string::npos);
}

TEST_CASE("deviations: a map whose comparison or mesh was deleted meanwhile is not served or cached") {
  HeldUp held;
  REQUIRE(held.map()->status == 200);
  REQUIRE(held.maps.counters().files == 1);
  SUBCASE("the comparison") {
    CHECK(held.client().Delete(held.comparison)->status == 204);
    const auto late = held.late();
    REQUIRE(late);
    CHECK(late->status == 200);  // it was there when it was asked for
    CHECK(late->get_header_value("Server-Timing").starts_with("queue;dur="));
    CHECK(held.map()->status == 404);
  }
  SUBCASE("a mesh") {
    CHECK(held.client().Delete("/v1/meshes/" + held.a)->status == 204);
    const auto late = held.late();
    REQUIRE(late);
    CHECK(late->status == 410);
    CHECK(held.map()->status == 410);
  }
  CHECK(held.maps.counters().files == 0);
}
