// Jobs over real stores and a stand-in for the readers, for its tests and its stress test.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "flaky_store.h"
#include "server/jobs/jobs.h"
#include "server/main/checked.h"
#include "tests/eventually.h"
#include "tests/server/stand_in.h"
#include "tests/server/store/implementations.h"

namespace meshgauge::server {

inline constexpr std::chrono::seconds kLong{60};  // longer than anything here takes

inline api::ProblemKind refusal_of(const Jobs::Submitted& submitted) {
  REQUIRE(std::holds_alternative<Denial>(submitted));
  return std::get<Denial>(submitted).problem.kind;
}

// Returns the meshes when it is released or the job is interrupted: a comparison runs until then.
struct Stand : MeshLoader {
  std::atomic<int> running{0};  // that were begun
  std::atomic<bool> released{false};
  std::atomic<bool> deaf{false};  // ignores a cancel
  std::mutex mutex;
  std::vector<std::string> order;  // file names of a
  std::vector<Control::Clock::time_point> deadlines;

  Result<api::SharedMesh> load(const MeshSource& source, MemoryReservation&, Control& control) override {
    if (source.input.part == "b") return stand_in(source);
    {
      const std::lock_guard lock(mutex);
      order.push_back(source.input.filename);
      deadlines.push_back(*control.deadline());
    }
    ++running;
    while (!released && (deaf || control.check() == Interruption::none)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return stand_in(source);
  }
};

// The stores, which outlive a service.
struct Kept {
  store::EmbeddedForTests embedded;
  store::FlakyStore jobs{embedded.jobs()};
  MeshCache cache{std::uint64_t{1} << 20};

  Stores stores() { return {jobs, embedded.meshes(), embedded.blobs(), embedded.signals(), cache}; }
};

inline Settings one_worker() {
  Settings settings;
  settings.workers = 1;
  settings.queue = 1;
  settings.max_queued_jobs = 100;
  return checked(settings).value();
}

struct Bench {
  explicit Bench(Kept& kept, MeshLoader& loader, Settings chosen = one_worker())
      : settings(std::move(chosen)), jobs(settings, loader, kept.stores(), access, metrics) {
    store::got(jobs.recover());
  }

  Settings settings;
  Access access{""};
  Metrics metrics;
  Jobs jobs;
};

inline MeshSource upload(const std::string& part, const std::string& text) {
  const auto bytes = std::make_shared<const std::string>(text);
  return {{part, store::bytes_of(*bytes), text + ".obj", "", -1}, bytes, "", {}};
}

inline MeshSource stored(Kept& kept, const std::string& part, const std::string& text, const std::string& owner = "") {
  const store::BlobKey key = store::key_of(owner, text);
  store::got(kept.embedded.blobs().put(key, store::bytes_of(text)));
  const auto now = store::now();
  store::got(
      kept.embedded.meshes().put_mesh({key, text.size(), "", "", now, now, now + std::chrono::hours(1)}, {1 << 20}));
  MeshSource source = source_of(part, std::move(*store::got(kept.embedded.blobs().open(key))), key.id);
  source.kept = MeshCache::key(owner, key.id, "", "");
  return source;
}

inline Submission submission(const std::string& a, bool durable, const std::string& idempotency_key = "") {
  Submission asked;
  asked.key = {"", api::random_id()};
  asked.options = "{}";
  asked.request = store::got(api::parse_options(asked.options));
  asked.a = upload("a", a);
  asked.b = upload("b", "the other");
  asked.durable = durable;
  asked.idempotency_key = idempotency_key;
  return asked;
}

inline Jobs::Submitted submit(Jobs& jobs, Submission asked) {
  auto slot = jobs.admit(asked.durable ? Jobs::Kind::durable : Jobs::Kind::awaited, "");
  REQUIRE(slot.has_value());
  return jobs.submit(std::move(*slot), std::move(asked));
}

inline std::shared_ptr<LiveJob> begun(Jobs::Submitted submitted) {
  if (const auto* denial = std::get_if<Denial>(&submitted)) FAIL(denial->problem.detail);
  REQUIRE(std::holds_alternative<std::shared_ptr<LiveJob>>(submitted));
  return std::get<std::shared_ptr<LiveJob>>(submitted);
}

inline store::Job row_of(Kept& kept, const store::JobKey& key) {
  const auto row = store::got(kept.embedded.jobs().get(key));
  REQUIRE(row.has_value());
  return *row;
}

}  // namespace meshgauge::server
