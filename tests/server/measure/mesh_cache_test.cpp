#include "server/measure/mesh_cache.h"

#include <malloc.h>

#include <atomic>
#include <fstream>
#include <future>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "api/base/digest.h"
#include "api/compare/compare.h"
#include "same_outcome.h"
#include "shapes.h"

using namespace meshgauge;
using server::MeshCache;

namespace {

using api::SharedMesh;

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 40;

std::string id_of(const std::string& name) { return api::sha256_hex(std::as_bytes(std::span(name))); }

MeshCache::Key key_of(const std::string& name, const std::string& owner = "") {
  return MeshCache::key(owner, id_of(name), "", "");
}

// Loads a mesh named by its bytes, and counts the loads.
struct Source {
  std::string name;
  Mesh mesh = shapes::sphere(20);
  std::atomic<int> loads{0};

  explicit Source(std::string of) : name(std::move(of)) {}

  Result<SharedMesh> operator()(Control&) {
    ++loads;
    const auto held = std::make_shared<const Mesh>(mesh);
    return std::make_shared<const api::PreparedMesh>(api::LoadedMesh{*held, api::Format::obj, {}, id_of(name), held},
                                                     10, Prepared::Use::often);
  }
};

Result<SharedMesh> get(MeshCache& cache, Source& source, const std::string& owner = "") {
  Control control;
  return cache.get(key_of(source.name, owner), std::ref(source), control);
}

SharedMesh take(MeshCache& cache, Source& source, const std::string& owner = "") {
  auto mesh = get(cache, source, owner);
  REQUIRE(mesh.ok());
  return *mesh;
}

// Uses the mesh like a comparison.
Outcome measured(const SharedMesh& a, const SharedMesh& b) {
  Control control;
  return measure(a->mesh, b->mesh, Options{}, control);
}

}  // namespace

TEST_CASE("mesh cache: a loaded mesh is found by its owner and format alone") {
  MeshCache cache(kPlenty);
  Source source("a");
  const SharedMesh first = take(cache, source);
  CHECK(take(cache, source) == first);
  CHECK(source.loads == 1);
  CHECK(take(cache, source, "another") != first);
  CHECK(source.loads == 2);
  Control control;
  const auto named = MeshCache::key("", id_of("a"), "part.STL.gz", "");
  CHECK(cache.get(named, std::ref(source), control).value() != first);
  CHECK(source.loads == 3);
  CHECK(named == MeshCache::key("", id_of("a"), "other.stl", "text/plain"));
  CHECK(named != MeshCache::key("", id_of("a"), "", "model/stl"));
  const auto counters = cache.counters();
  CHECK(counters.hits == 1);
  CHECK(counters.misses == 3);
  CHECK(counters.meshes == 3);
}

TEST_CASE("mesh cache: a comparison makes the trees, and they are counted when it is done") {
  MeshCache cache(kPlenty);
  Source a("a"), b("b");
  b.mesh = shapes::sphere(15, 1.1);
  Outcome first;
  {
    const SharedMesh mesh_a = take(cache, a), mesh_b = take(cache, b);
    CHECK(cache.counters().in_use == 2);
    first = measured(mesh_a, mesh_b);
  }
  const auto counters = cache.counters();
  CHECK(counters.in_use == 0);
  const SharedMesh again_a = take(cache, a), again_b = take(cache, b);
  CHECK(counters.bytes == again_a->bytes() + again_b->bytes());
  CHECK(again_a->bytes() > 3 * a.mesh.positions.size() * sizeof(Vec3));
  CHECK(same_outcome(measured(again_a, again_b), first));
  CHECK(a.loads + b.loads == 2);
}

TEST_CASE("mesh cache: over the budget the longest unused is evicted, never one in use") {
  Source sources[] = {Source("0"), Source("1"), Source("2"), Source("3")};
  MeshCache unlimited(kPlenty);
  const std::uint64_t one = take(unlimited, sources[0])->bytes();
  MeshCache cache(2 * one + one / 2);
  sources[0].loads = 0;
  std::weak_ptr<const api::PreparedMesh> second;
  {
    const SharedMesh held = take(cache, sources[0]);
    second = take(cache, sources[1]);
    (void)get(cache, sources[2]);
    CHECK(second.expired());
    CHECK(cache.counters().evictions == 1);
    CHECK(take(cache, sources[0]) == held);  // the oldest, but in use
    const SharedMesh more[] = {take(cache, sources[1]), take(cache, sources[2]), take(cache, sources[3])};
    CHECK(cache.counters().bytes == 4 * one);  // all in use
    CHECK(measured(held, more[2]).lower == 0);
  }
  CHECK(cache.counters().bytes <= 2 * one + one / 2);
  CHECK(cache.counters().in_use == 0);
  const int loads = sources[0].loads;
  (void)get(cache, sources[0]);  // the last one in use
  CHECK(sources[0].loads == loads);
}

TEST_CASE("mesh cache: trees that outgrow the budget take their mesh along") {
  Source small("small"), large("large");
  small.mesh = shapes::cube();
  MeshCache unlimited(kPlenty);
  MeshCache cache(take(unlimited, large)->bytes() * 2);
  (void)get(cache, small);
  {
    const SharedMesh mesh = take(cache, large);
    (void)measured(mesh, take(cache, small));
  }
  CHECK(cache.counters().evictions == 1);
  (void)get(cache, small);
  CHECK(small.loads == 1);
}

TEST_CASE("mesh cache: a mesh larger than the budget is returned, evicts none, and is not cached") {
  Source small("small"), large("large");
  small.mesh = shapes::cube();
  MeshCache cache(20'000);
  (void)get(cache, small);
  CHECK(take(cache, large)->facts.triangles == large.mesh.triangles.size());
  CHECK(cache.counters().meshes == 1);
  CHECK(cache.counters().in_use == 0);
  (void)get(cache, small);
  CHECK(small.loads == 1);
  MeshCache none(0);
  CHECK(get(none, small).ok());
  CHECK(none.counters().meshes == 0);
  CHECK(none.counters().bytes == 0);
}

TEST_CASE("mesh cache: a forgotten mesh is loaded again, and lives while it is in use") {
  MeshCache cache(kPlenty);
  Source source("a");
  SharedMesh held = take(cache, source);
  (void)get(cache, source, "another");
  cache.forget("", id_of("a"));
  cache.forget("", id_of("b"));
  CHECK(cache.counters().meshes == 1);
  CHECK(measured(held, held).upper == 0);
  const SharedMesh other = take(cache, source);
  CHECK(other != held);
  const std::weak_ptr<const api::PreparedMesh> watched = held;
  held.reset();
  CHECK(watched.expired());
  (void)get(cache, source, "another");
  CHECK(source.loads == 3);
  CHECK(cache.counters().evictions == 0);
}

TEST_CASE("mesh cache: the mesh outlives the cache while it is in use") {
  Source source("a");
  SharedMesh held;
  {
    MeshCache cache(kPlenty);
    held = take(cache, source);
  }
  CHECK(held->facts.triangles == source.mesh.triangles.size());
}

TEST_CASE("mesh cache: failures are not cached, nor bytes with another digest") {
  MeshCache cache(kPlenty);
  Source source("a");
  Control control;
  const MeshCache::Load refuses = [](Control&) { return Error{ErrorCode::unreadable_mesh, "no mesh", "a", ""}; };
  const MeshCache::Load throws = [](Control&) -> Result<SharedMesh> { throw std::bad_alloc(); };
  CHECK(cache.get(key_of("a"), refuses, control).error().message == "no mesh");
  CHECK_THROWS_AS((void)cache.get(key_of("a"), throws, control), std::bad_alloc);
  const auto damaged = cache.get(key_of("b"), std::ref(source), control);
  REQUIRE(!damaged.ok());
  CHECK(damaged.error().code == ErrorCode::internal);
  CHECK(cache.counters().meshes == 0);
  CHECK(get(cache, source).ok());
}

TEST_CASE("mesh cache: one load at a time for a mesh, waiting calls can be stopped, and load when the first fails") {
  MeshCache cache(kPlenty);
  Source source("a");
  std::promise<void> begun, end;
  const MeshCache::Load slow = [&](Control&) -> Result<SharedMesh> {
    begun.set_value();
    end.get_future().wait();
    return Error{ErrorCode::unreadable_mesh, "no mesh", "a", ""};
  };
  auto first = std::async(std::launch::async, [&] {
    Control control;
    return cache.get(key_of("a"), slow, control);
  });
  begun.get_future().wait();
  Control late(Control::Clock::now() + std::chrono::milliseconds(30));
  const auto stopped = cache.get(key_of("a"), std::ref(source), late);
  REQUIRE(!stopped.ok());
  CHECK(stopped.error().code == ErrorCode::out_of_time);
  CHECK(source.loads == 0);
  Source other("other");
  CHECK(get(cache, other).ok());  // does not block

  std::vector<std::future<Result<SharedMesh>>> waiting;
  waiting.reserve(4);
  for (int i = 0; i < 4; ++i) waiting.push_back(std::async(std::launch::async, [&] { return get(cache, source); }));
  end.set_value();
  CHECK(!first.get().ok());
  for (auto& each : waiting) CHECK(each.get().ok());
  CHECK(source.loads == 1);
}

TEST_CASE("mesh cache: a mesh that is forgotten during its load is returned and not cached") {
  MeshCache cache(kPlenty);
  Source source("a");
  const MeshCache::Load load = [&](Control& control) {
    cache.forget("", id_of("a"));
    return source(control);
  };
  Control control;
  CHECK(cache.get(key_of("a"), load, control).ok());
  CHECK(cache.counters().meshes == 0);
  CHECK(cache.counters().bytes == 0);
}

TEST_CASE("mesh cache: concurrent use with little room measures the same as alone") {
  std::vector<std::unique_ptr<Source>> sources;
  for (std::uint32_t i = 0; i < 6; ++i) {
    sources.push_back(std::make_unique<Source>(std::to_string(i)));
    sources.back()->mesh = shapes::sphere(8 + i, 1 + 0.01 * i);
  }
  std::vector<Outcome> alone;
  for (const auto& source : sources) {
    Control control;
    alone.push_back(measure(sources[0]->mesh, source->mesh, Options{}, control));
  }
  MeshCache cache(300'000);  // two or three of them with their trees
  std::vector<std::future<int>> threads;
  for (std::uint32_t thread = 0; thread < 4; ++thread) {
    threads.push_back(std::async(std::launch::async, [&, thread] {
      int wrong = 0;
      std::mt19937_64 random(thread);
      for (int i = 0; i < 40; ++i) {
        const std::size_t which = random() % sources.size();
        if (i % 10 == 9) cache.forget("", id_of(sources[which]->name));
        const SharedMesh a = take(cache, *sources[0]), b = take(cache, *sources[which]);
        wrong += same_outcome(measured(a, b), alone[which]) ? 0 : 1;
      }
      return wrong;
    }));
  }
  for (auto& thread : threads) CHECK(thread.get() == 0);
  CHECK(cache.counters().in_use == 0);
  CHECK(cache.counters().bytes <= 300'000);
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t pages = 0, resident = 0;
  statm >> pages >> resident;
  return resident * 4096;
}

}  // namespace

TEST_CASE("mesh cache: the memory of evicted meshes returns to the system") {
  ::malloc_trim(0);  // memory that other tests have left
  const std::size_t before = resident_bytes();
  std::size_t most = 0;
  {
    MeshCache cache(kPlenty);
    for (int i = 0; i < 60; ++i) {  // of sizes that the allocator would keep
      Source source(std::to_string(i));
      source.mesh = shapes::sphere(60);
      const SharedMesh mesh = take(cache, source);
      (void)measured(mesh, mesh);
      (void)std::async(std::launch::async, [&] { return measured(mesh, take(cache, source)); }).get();
    }
    for (int i = 0; i < 60; ++i) {
      most = std::max(most, resident_bytes());
      cache.forget("", id_of(std::to_string(i)));
    }
    CHECK(resident_bytes() < before + (most - before) / 2);
  }
  CHECK(most > before + (std::size_t{20} << 20));
}
#endif
