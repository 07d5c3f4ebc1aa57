// Front ends as their clients see them: services that share stores, and a worker played by the test.
#include <future>
#include <string>

#include <nlohmann/json.hpp>

#include "server/http/http_library.h"
#include "server/main/checked.h"
#include "server/main/service.h"
#include "tests/server/jobs/shared_bench.h"

using namespace meshgauge;
using namespace meshgauge::server;
using nlohmann::json;
using store::JobState;

namespace {

Settings of_a_service() {
  Settings settings;
  settings.port = 0;
  settings.workers = 1;
  settings.queue = 2;
  settings.io_threads = 8;
  settings.max_event_streams = 2;
  return checked(settings).value();
}

struct Served {
  explicit Served(Common& kept)
      : common(kept),
        service(of_a_service(), loader,
                Stores{kept.jobs, kept.embedded.meshes(), kept.embedded.blobs(), signals, cache, true}) {
    common.jobs.tell_to(signals);
    port = service.start().value();
  }
  ~Served() {
    service.shutdown([] { return true; });
    common.jobs.tell_no_more(signals);
  }

  httplib::Result post(const httplib::Headers& headers = {}) const {
    return client().Post("/v1/comparisons", headers,
                         {{"a", "mesh a", "a.obj", ""}, {"b", "mesh b", "b.obj", ""}, {"options", "{}", "", ""}});
  }
  httplib::Result get(const std::string& path) const { return client().Get(path); }
  httplib::Client client() const {
    httplib::Client one("127.0.0.1", port);
    one.set_read_timeout(60);
    return one;
  }

  Common& common;
  store::HandSignals signals;
  MeshCache cache{0};
  LoadsNothing loader;
  Service service;
  int port = 0;
};

// Once there is something to claim.
store::Claimed claim_one(Common& common, Hands& hands) {
  REQUIRE(eventually([&] { return store::got(common.embedded.jobs().counts()).queued == 1; }));
  return hands.claim();
}

std::string type_of(const httplib::Result& answer) { return json::parse(answer->body)["type"]; }

}  // namespace

TEST_CASE("front end: a waiting client gets the worker's result, and any front end shows it") {
  Common common;
  Served one(common), other(common);
  Hands hands(common);
  auto client = std::async(std::launch::async, [&] { return one.post(); });
  const auto claimed = claim_one(common, hands);
  hands.finish(claimed);
  const auto answer = client.get();
  REQUIRE(answer);
  CHECK(answer->status == 200);
  CHECK(answer->get_header_value("Server-Timing") == "queue;dur=1.500, total;dur=2.250");
  const json document = json::parse(answer->body);
  CHECK(document["id"] == claimed.job.key.id);
  CHECK(document["id"] == answer->get_header_value("X-Request-Id"));
  CHECK(json::parse(other.get("/v1/comparisons/" + claimed.job.key.id)->body)["result"] == document);
}

TEST_CASE("front end: a job's events arrive wherever it runs") {
  Common common;
  Served one(common), other(common);
  Hands hands(common);
  const auto accepted = one.post({{"Prefer", "respond-async"}});
  REQUIRE(accepted->status == 202);
  const auto claimed = claim_one(common, hands);
  std::atomic<bool> seen{false};
  auto events = std::async(std::launch::async, [&] {
    std::string text;
    other.client().Get(accepted->get_header_value("Location") + "/events", [&](const char* data, std::size_t size) {
      text.append(data, size);
      seen = seen || text.find(R"("lower":0.5)") != std::string::npos;
      return true;
    });
    return text;
  });
  REQUIRE(eventually([&] {
    hands.beat(claimed, {0.5, 2, "traverse"});
    return seen.load();
  }));
  hands.finish(claimed);
  const std::string text = events.get();
  const std::size_t end = text.find("event: end\ndata: ");
  REQUIRE(end != std::string::npos);
  CHECK(text.find("event: ", end + 1) == std::string::npos);
  CHECK(text.find("\"state\":\"done\"", end) != std::string::npos);
}

TEST_CASE("front end: without its store it is alive, not ready, and refuses requests that need it") {
  Common common;
  Served front(common);
  CHECK(front.get("/readyz")->status == 200);
  common.jobs.gone = true;
  REQUIRE(eventually([&] { return front.get("/readyz")->status == 503; }));
  CHECK(front.get("/readyz")->body.find("the database is gone") != std::string::npos);
  CHECK(front.get("/healthz")->status == 200);
  for (const auto& answer : {front.post(), front.post({{"Prefer", "respond-async"}}),
                             front.post({{"Idempotency-Key", "k"}}), front.get("/v1/comparisons/x")}) {
    REQUIRE(answer);
    CHECK(answer->status == 503);
    CHECK(answer->has_header("Retry-After"));
    CHECK(type_of(answer) == "/problems/storage-unavailable");
  }
  common.jobs.gone = false;
  CHECK(eventually([&] { return front.get("/readyz")->status == 200; }));
}

TEST_CASE("front end: a client that disconnects cancels its comparison") {
  Common common;
  Served front(common);
  Hands hands(common);
  {
    auto impatient = front.client();
    impatient.set_read_timeout(0, 200'000);
    impatient.Post("/v1/comparisons",
                   {{"a", "mesh a", "a.obj", ""}, {"b", "mesh b", "b.obj", ""}, {"options", "{}", "", ""}});
  }
  CHECK(eventually([&] { return store::got(common.embedded.jobs().counts()).cancelled == 1; }));
}

TEST_CASE("front end: at shutdown waiting clients get shutting-down, and durable jobs stay queued") {
  Common common;
  std::future<httplib::Result> awaited, promised;
  {
    Served front(common);
    awaited = std::async(std::launch::async, [&front] { return front.post(); });
    promised = std::async(std::launch::async, [&front] { return front.post({{"Idempotency-Key", "k"}}); });
    REQUIRE(eventually([&] { return store::got(common.embedded.jobs().counts()).queued == 2; }));
    front.service.shutdown([] { return true; });
    for (auto* client : {&awaited, &promised}) {
      const auto answer = client->get();
      REQUIRE(answer);
      CHECK(answer->status == 503);
      CHECK(type_of(answer) == "/problems/shutting-down");
    }
  }
  const auto counts = store::got(common.embedded.jobs().counts());
  CHECK(counts.queued == 1);
  CHECK(counts.cancelled == 1);
}
