// Comparisons in parts, over PostgreSQL: a front end, and workers with stores of their own as those of several
// machines.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench_of_workers.h"
#include "server/jobs/job_document.h"
#include "shapes.h"
#include "tests/server/store/postgres_for_tests.h"

using namespace meshgauge;
using namespace meshgauge::server;
using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::seconds;
using store::got;
using store::JobState;

namespace {

constexpr seconds kLong{60};

std::string obj_of(const Mesh& mesh) {
  std::string text;
  char line[100];
  for (const Vec3& p : mesh.positions) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    text += line;
  }
  for (const Triangle& t : mesh.triangles) {
    std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    text += line;
  }
  return text;
}

Result<api::Comparison> really(const MeshSource& a, const MeshSource& b, const Options& options,
                               const api::ReadLimits& limits, Control& control) {
  return api::compare_by(&api::load, a.input, b.input, options, limits, control);
}

Stores stores_in(store::DistributedStores& stores, MeshCache& cache) {
  return {stores.jobs(), stores.meshes(),  stores.blobs(),    cache,
          nullptr,       stores.signals(), &stores.batches(), stores.parts()};
}

// One process that runs comparisons.
struct Machine {
  Machine(const store::PostgresForTests& database, const std::string& name, Compare compare, std::uint64_t threads = 1)
      : stores(database.open(name)),
        bench(stores_in(*stores, cache), std::move(compare), options_of(name), with_threads(threads)) {
    bench.worker.start();
  }
  double claimed() const { return bench.metric("meshgauge_worker_claimed_total"); }

  std::unique_ptr<store::DistributedStores> stores;
  MeshCache cache{std::uint64_t{64} << 20};
  WorkerBench bench;
};

// One that lets them in.
struct Entrance {
  explicit Entrance(const store::PostgresForTests& database)
      : stores(database.open("front")), jobs(settings, &really, stores_in(*stores, cache), access, metrics) {}

  std::shared_ptr<LiveJob> begin(const std::string& a, const std::string& b, const std::string& options,
                                 bool durable = true) {
    Submission asked = submission("", durable);
    asked.options = options;
    asked.request = got(api::parse_options(options));
    asked.a = named("a", a);
    asked.b = named("b", b);
    return begun(submit(jobs, std::move(asked)));
  }
  static MeshSource named(const std::string& part, const std::string& text) {
    MeshSource source = upload(part, text);
    source.input.filename = part + ".obj";
    return source;
  }
  json ended(const std::shared_ptr<LiveJob>& job) const {
    REQUIRE(job->wait_for_end(kLong));
    return json::parse(to_json(job->view()));
  }

  std::unique_ptr<store::DistributedStores> stores;
  Settings settings = one_worker();
  MeshCache cache{0};
  Access access{""};
  Metrics metrics;
  Jobs jobs;
};

const std::string& ball() {
  static const std::string text = obj_of(shapes::sphere(40));
  return text;
}
const std::string& other_ball() {
  static const std::string text = obj_of(shapes::sphere(33, 1.02, Vec3(0.01, 0, 0)));
  return text;
}

// Waits in each part until it is let go; says what it was told by the others.
struct Waiting {
  std::atomic<int> parts{0};
  std::atomic<bool> released{false};
  std::atomic<bool> told{false};

  Compare compare() {
    return [this](const MeshSource& a, const MeshSource&, const Options& options, const api::ReadLimits&,
                  Control& control) -> Result<api::Comparison> {
      const bool is_part = options.part.count > 1;
      if (is_part) {
        ++parts;
        control.report({options.part.index == 0 ? 5.25 : 1, 9, "reduce"});
      }
      while (is_part && !released && control.check() == Interruption::none) {
        if (options.part.index != 0 && control.known_lower() == 5.25) told = true;
        std::this_thread::sleep_for(milliseconds(1));
      }
      api::Comparison comparison = stand_in(a, options);
      if (control.check() == Interruption::cancelled) comparison.outcome.stop = Stop::cancelled;
      return comparison;
    };
  }
};

}  // namespace

TEST_CASE("parts: on two workers they give what one piece gives") {
  const store::PostgresForTests database;
  Entrance front(database);
  Machine one(database, "one", &really), two(database, "two", &really, 2);
  const json whole = front.ended(front.begin(ball(), other_ball(), R"({"tolerance":{"diagonal":1e-6}})"));
  REQUIRE(whole["result"].is_object());
  CHECK(whole["result"]["engine"]["shards"] == 1);
  for (const bool durable : {true, false}) {
    for (const int shards : {2, 5}) {
      const std::string options = R"({"tolerance":{"diagonal":1e-6},"gate":{"max_distance":1},"shards":)";
      const json job = front.ended(front.begin(ball(), other_ball(), options + std::to_string(shards) + "}", durable));
      CHECK(job["state"] == "done");
      const json& result = job["result"];
      CHECK(result["engine"]["shards"] == shards);
      CHECK(result["verdict"] == "pass");
      CHECK(result["id"] == job["id"]);
      CHECK(result["distance"]["lower"] <= whole["result"]["distance"]["upper"]);
      CHECK(whole["result"]["distance"]["lower"] <= result["distance"]["upper"]);
      CHECK(result["meshes"] == whole["result"]["meshes"]);
      for (const char* way : {"a_to_b", "b_to_a"}) {
        CHECK(result[way]["culling"]["triangles"] == whole["result"][way]["culling"]["triangles"]);
      }
    }
  }
  CHECK(one.claimed() + two.claimed() == 1 + 2 * (3 + 6));
  CHECK(got(front.stores->jobs().counts()).done == 5);
  CHECK(front.jobs.figures().awaited_slots == 0);
}

TEST_CASE("parts: each hears what others have found, and who watches sees the whole's interval") {
  const store::PostgresForTests database;
  Entrance front(database);
  Waiting waiting;
  Machine one(database, "one", waiting.compare()), two(database, "two", waiting.compare());
  const auto job = front.begin("a", "b", R"({"shards":2})");
  CHECK(eventually([&] { return waiting.told.load(); }));
  CHECK(eventually([&] { return job->view().row.progress == std::optional(certified(5.25, 9, "reduce")); }));
  CHECK(json::parse(progress_json(job->view()))["state"] == "running");
  const auto row = got(front.jobs.get(job->key));
  CHECK(json::parse(to_json(*row))["progress"] == json{{"lower", 5.25}, {"upper", 9.0}, {"stage", "reduce"}});
  CHECK_FALSE(got(front.jobs.get(part_key(job->key, 0))).has_value());  // nobody has asked for that
  waiting.released = true;
  // What a stand-in says of parts makes no whole: it is measured in one piece.
  const json ended = front.ended(job);
  CHECK(ended["state"] == "done");
  CHECK(ended["result"]["engine"]["shards"] == 1);
  CHECK(waiting.parts == 2);
}

TEST_CASE("parts: the whole fails as one of them did") {
  const store::PostgresForTests database;
  Entrance front(database);
  Machine one(database, "one", &really, 2);
  const json job = front.ended(front.begin(ball(), "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", R"({"shards":3})"));
  CHECK(job["state"] == "failed");
  CHECK(job["result"].is_null());
  CHECK(job["problem"]["type"].get<std::string>().find("non-finite") != std::string::npos);
}

TEST_CASE("parts: one that fails ends the others") {
  const store::PostgresForTests database;
  Entrance front(database);
  Waiting waiting;
  const Compare others = waiting.compare();
  const Compare compare = [&](const MeshSource& a, const MeshSource& b, const Options& options,
                              const api::ReadLimits& limits, Control& control) -> Result<api::Comparison> {
    if (options.part.index != 1) return others(a, b, options, limits, control);
    while (waiting.parts < 1) std::this_thread::sleep_for(milliseconds(1));
    return Error{ErrorCode::too_large, "of a test's making", "a", ""};
  };
  Machine one(database, "one", compare), two(database, "two", compare);
  const json job = front.ended(front.begin("a", "b", R"({"shards":2})"));
  CHECK(job["state"] == "failed");
  CHECK(job["problem"]["detail"].get<std::string>().find("of a test's making") != std::string::npos);
}

TEST_CASE("parts: who cancels the whole ends them") {
  const store::PostgresForTests database;
  Entrance front(database);
  Waiting waiting;
  Machine one(database, "one", waiting.compare()), two(database, "two", waiting.compare());
  const auto job = front.begin("a", "b", R"({"shards":3})");
  REQUIRE(eventually([&] { return waiting.parts == 2; }));
  CHECK(got(front.jobs.remove(job->key)) == Jobs::Deleted::asked_to_end);
  CHECK(front.ended(job)["state"] == "cancelled");
  CHECK(eventually([&] { return one.bench.worker.held() == 0 && two.bench.worker.held() == 0; }));
  CHECK(waiting.parts == 2);
  CHECK(got(front.jobs.remove(job->key)) == Jobs::Deleted::forgotten);
  CHECK(got(front.stores->parts()->parts(job->key)).empty());
}

TEST_CASE("parts: what one worker leaves another finishes") {
  const store::PostgresForTests database;
  Entrance front(database);
  Waiting waiting;
  auto first = std::make_unique<Machine>(database, "one", waiting.compare(), 2);
  const auto job = front.begin(ball(), other_ball(), R"({"tolerance":{"diagonal":1e-6},"shards":2})");
  REQUIRE(eventually([&] { return waiting.parts == 2; }));
  first->bench.worker.stop();
  first.reset();
  Machine second(database, "two", &really, 2);
  const json ended = front.ended(job);
  CHECK(ended["state"] == "done");
  CHECK(ended["result"]["engine"]["shards"] == 2);
  CHECK(ended["result"]["status"] == "converged");
}
