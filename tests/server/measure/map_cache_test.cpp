#include "server/measure/map_cache.h"

#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::MapCache;
using server::MapKey;
namespace fs = std::filesystem;

namespace {

// A cache in a temporary folder.
struct KeptMaps {
  fs::path root;
  MapCache cache;

  explicit KeptMaps(std::uint64_t max_bytes, const std::string& temp_dir = "/tmp",
                    std::function<std::uint64_t()> lacking = nullptr)
      : root(made_folder()), cache({root / "maps", max_bytes, temp_dir, std::move(lacking)}) {
    fs::create_directory(root / "maps");
    std::ofstream(root / "maps" / "left.part") << "x";
    REQUIRE(cache.open().ok());
  }
  ~KeptMaps() {
    fs::permissions(root / "maps", fs::perms::owner_all);
    fs::remove_all(root);
  }
  KeptMaps(const KeptMaps&) = delete;
  KeptMaps& operator=(const KeptMaps&) = delete;

  static fs::path made_folder() {
    std::string name = (fs::temp_directory_path() / "meshgauge-maps-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    return name;
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(root / "maps"), {}));
  }
};

MapKey key(const std::string& job, const std::string& name = "a.ply", const std::string& owner = "owner") {
  return {{owner, job}, name};
}

MapCache::Write writing(const std::string& text) {
  return [text](std::ostream& out) -> Result<Done> {
    out << text;
    return Done{};
  };
}

Result<MapCache::File> keep(MapCache& cache, const MapKey& map, const std::vector<std::string>& meshes,
                            const MapCache::Write& write) {
  return cache.keep(*cache.expect(map, meshes), write);
}

std::string text_of(const MapCache::File& file) {
  return {reinterpret_cast<const char*>(file->bytes().data()), file->bytes().size()};
}

}  // namespace

TEST_CASE("map cache: a map is found by its whole key alone") {
  KeptMaps kept(1000);
  CHECK(kept.files() == 0);  // files of an earlier process
  CHECK(kept.cache.find(key("1")) == nullptr);
  const auto made = keep(kept.cache, key("1"), {}, writing("map"));
  REQUIRE(made.ok());
  CHECK(text_of(*made) == "map");
  CHECK(text_of(kept.cache.find(key("1"))) == "map");
  CHECK(kept.cache.find(key("2")) == nullptr);
  CHECK(kept.cache.find(key("1", "b.ply")) == nullptr);
  CHECK(kept.cache.find(key("1", "a.ply", "other")) == nullptr);
  const auto entry = *fs::directory_iterator(kept.root / "maps");
  CHECK((entry.status().permissions() & (fs::perms::group_all | fs::perms::others_all)) == fs::perms::none);
  CHECK(entry.path().filename().string().size() == 32);
}

TEST_CASE("map cache: the longest unused are removed, and open files stay readable") {
  KeptMaps kept(10);
  for (const char* job : {"1", "2"}) REQUIRE(keep(kept.cache, key(job), {}, writing("1234")).ok());
  const auto second = kept.cache.find(key("2"));
  CHECK(kept.cache.find(key("1")) != nullptr);  // used after the other one
  REQUIRE(keep(kept.cache, key("3"), {}, writing("1234")).ok());
  CHECK(kept.cache.find(key("2")) == nullptr);
  CHECK(kept.cache.find(key("1")) != nullptr);
  CHECK(text_of(second) == "1234");
  const auto counters = kept.cache.counters();
  CHECK(counters.bytes == 8);
  CHECK(counters.files == 2);
  CHECK(counters.evictions == 1);
  CHECK(kept.files() == 2);
}

TEST_CASE("map cache: a repeated map replaces the first") {
  KeptMaps kept(10);
  for (const char* text : {"12345678", "abcdefgh"}) REQUIRE(keep(kept.cache, key("1"), {}, writing(text)).ok());
  CHECK(text_of(kept.cache.find(key("1"))) == "abcdefgh");
  CHECK(kept.cache.counters().bytes == 8);
  CHECK(kept.files() == 1);
}

TEST_CASE("map cache: a map larger than the budget, or without one, is made and not cached") {
  for (const std::uint64_t budget : {0U, 3U}) {
    KeptMaps kept(budget);
    const auto made = keep(kept.cache, key("1"), {}, writing("1234"));
    REQUIRE(made.ok());
    CHECK(text_of(*made) == "1234");
    CHECK(kept.cache.find(key("1")) == nullptr);
    if (budget > 0) CHECK(kept.files() == 0);
  }
}

TEST_CASE("map cache: large and empty files are complete") {
  KeptMaps kept(std::uint64_t{1} << 30);
  std::string text(3'000'001, 'x');
  text[1'234'567] = 'y';
  CHECK(text_of(keep(kept.cache, key("1"), {}, writing(text)).value()) == text);
  CHECK(text_of(kept.cache.find(key("1"))) == text);
  CHECK(text_of(keep(kept.cache, key("2"), {}, writing("")).value()).empty());
}

TEST_CASE("map cache: a failed map leaves nothing") {
  KeptMaps kept(1000);
  const auto failing = [](std::ostream& out) -> Result<Done> {
    out << "half";
    return Error{ErrorCode::too_large, "too large", "", ""};
  };
  CHECK(keep(kept.cache, key("1"), {}, failing).error().code == ErrorCode::too_large);
  CHECK_THROWS((void)keep(kept.cache, key("1"), {}, [](std::ostream&) -> Result<Done> { throw std::bad_alloc(); }));
  CHECK(kept.files() == 0);
  CHECK(kept.cache.find(key("1")) == nullptr);
}

TEST_CASE("map cache: without a folder a map is still made, without any disk it is an error") {
  KeptMaps kept(1000);
  fs::remove(kept.root / "maps");  // like a disk that takes no files, also for root
  CHECK(text_of(keep(kept.cache, key("1"), {}, writing("map")).value()) == "map");
  CHECK(kept.cache.find(key("1")) == nullptr);
  fs::create_directory(kept.root / "maps");
  KeptMaps nowhere(0, "/no/such/folder");
  CHECK(keep(nowhere.cache, key("1"), {}, writing("map")).error().code == ErrorCode::storage_unavailable);
}

TEST_CASE("map cache: maps are removed for room that the disk lacks, the longest unused first") {
  std::uint64_t lacking = 0;
  KeptMaps kept(1000, "/tmp", [&] { return lacking; });
  for (const char* job : {"1", "2", "3"}) REQUIRE(keep(kept.cache, key(job), {}, writing("1234")).ok());
  kept.cache.give_way();
  CHECK(kept.files() == 3);
  CHECK(kept.cache.find(key("1")) != nullptr);  // used after the others
  lacking = 5;
  kept.cache.give_way();
  CHECK(kept.files() == 1);
  CHECK(kept.cache.find(key("1")) != nullptr);
  lacking = 4;
  REQUIRE(keep(kept.cache, key("4"), {}, writing("1234")).ok());
  CHECK(kept.cache.find(key("1")) == nullptr);
  CHECK(kept.cache.find(key("4")) != nullptr);
  lacking = 1000;
  CHECK(text_of(keep(kept.cache, key("5"), {}, writing("map")).value()) == "map");  // returned, and not cached
  CHECK(kept.files() == 0);
  CHECK(kept.cache.counters().bytes == 0);
  kept.cache.give_way();
}

TEST_CASE("map cache: a map without room to be cached frees room for its client") {
  std::uint64_t lacking = 0;
  KeptMaps kept(1000, "/tmp", [&] { return lacking; });
  REQUIRE(keep(kept.cache, key("1"), {}, writing("1234")).ok());
  lacking = 4;
  int tries = 0;
  const auto made = keep(kept.cache, key("2"), {}, [&](std::ostream& out) -> Result<Done> {
    if (++tries == 1) return Error{ErrorCode::storage_full, "no room", "", ""};
    CHECK(kept.files() == 0);
    out << "map";
    return Done{};
  });
  CHECK(text_of(made.value()) == "map");
  CHECK(tries == 2);
}

TEST_CASE("spare room: the wanted bytes, or a share of a small disk") {
  constexpr std::uint64_t kAll = std::uint64_t{1} << 40, kShare = kAll / 64;
  using server::lacking_bytes;
  CHECK(lacking_bytes({kAll, kAll}, 1000) == 0);
  CHECK(lacking_bytes({kAll, 1000}, 1000) == 0);
  CHECK(lacking_bytes({kAll, 400}, 1000) == 600);
  CHECK(lacking_bytes({kAll, 400}, kAll) == kShare - 400);
  CHECK(lacking_bytes({kAll, kShare}, kAll) == 0);
  CHECK(lacking_bytes({kAll, 0}, 0) == 0);
  CHECK(server::lacking_bytes_on("/tmp", 0) == 0);
  CHECK(server::lacking_bytes_on("/no/such/folder", kAll) == 0);
}

TEST_CASE("map cache: jobs and meshes are forgotten") {
  KeptMaps kept(1000);
  for (const char* name : {"a.ply", "b.ply"}) REQUIRE(keep(kept.cache, key("1", name), {"m", "n"}, writing("x")).ok());
  REQUIRE(keep(kept.cache, key("2"), {"n", "o"}, writing("x")).ok());
  REQUIRE(keep(kept.cache, key("3"), {"o", "p"}, writing("x")).ok());
  REQUIRE(keep(kept.cache, key("1", "a.ply", "other"), {"n", "n"}, writing("x")).ok());
  kept.cache.forget({"owner", "1"});
  CHECK(kept.files() == 3);
  CHECK(kept.cache.find(key("1", "a.ply", "other")) != nullptr);
  kept.cache.forget_mesh("owner", "n");
  CHECK(kept.cache.find(key("2")) == nullptr);
  CHECK(kept.cache.find(key("3")) != nullptr);
  kept.cache.sweep([](const server::store::JobKey& job) { return job.owner == "other"; });
  CHECK(kept.cache.find(key("3")) == nullptr);
  CHECK(kept.cache.counters().files == 1);
}

TEST_CASE("map cache: a map that is forgotten while it is made is not cached") {
  KeptMaps kept(1000);
  const auto kept_after = [&](const std::function<void()>& event) {
    const auto coming = kept.cache.expect(key("1"), {"m", "n"});
    event();
    CHECK(text_of(kept.cache.keep(*coming, writing("x")).value()) == "x");
    const bool found = kept.cache.find(key("1")) != nullptr;
    kept.cache.forget({"owner", "1"});
    CHECK(kept.files() == 0);
    return found;
  };
  CHECK_FALSE(kept_after([&] { kept.cache.forget({"owner", "1"}); }));
  CHECK_FALSE(kept_after([&] { kept.cache.forget_mesh("owner", "n"); }));
  CHECK_FALSE(kept_after([&] { kept.cache.sweep([](const auto&) { return false; }); }));
  CHECK(kept_after([&] { kept.cache.forget({"owner", "2"}); }));
  CHECK(kept_after([&] { kept.cache.forget_mesh("other", "n"); }));
  CHECK(kept_after([&] { kept.cache.sweep([](const auto&) { return true; }); }));
}

TEST_CASE("map cache: a file that was deleted from outside is not found") {
  KeptMaps kept(1000);
  REQUIRE(keep(kept.cache, key("1"), {}, writing("x")).ok());
  fs::remove(*fs::directory_iterator(kept.root / "maps"));
  CHECK(kept.cache.find(key("1")) == nullptr);
  REQUIRE(keep(kept.cache, key("1"), {}, writing("y")).ok());
  CHECK(text_of(kept.cache.find(key("1"))) == "y");
}

TEST_CASE("map cache: concurrent use") {
  KeptMaps kept(200);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 100; ++i) {
        const std::string job = std::to_string((i * 7 + t) % 11);
        const std::string text(20 + job.size(), job[0]);
        auto file = kept.cache.find(key(job));
        if (!file) file = keep(kept.cache, key(job), {job}, writing(text)).value();
        wrong += text_of(file) != text;
        if (i % 10 == t) kept.cache.forget({"owner", job});
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  CHECK(kept.cache.counters().bytes <= 200);
  CHECK(kept.files() == kept.cache.counters().files);
}
