#include "server/store/blob_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "store_text.h"
#include "test_folder.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

// Returns `text` in pieces, and counts the fetches.
struct Source {
  std::string text;
  std::atomic<int> fetches{0};

  BlobCache::Fetch fetch() {
    return [this](const RemoteBlobs::Take& take) -> Result<bool> {
      ++fetches;
      for (std::size_t at = 0; at < text.size(); at += 1000) {
        const Result<Done> taken = take(bytes_of(std::string_view(text).substr(at, 1000)));
        if (!taken) return taken.error();
      }
      return true;
    };
  }
};

const BlobCache::Fetch kNone = [](const RemoteBlobs::Take&) { return Result<bool>(false); };

class Cache {
 public:
  explicit Cache(std::uint64_t max_bytes = 1'000'000) { reopen(max_bytes); }

  void reopen(std::uint64_t max_bytes = 1'000'000) {
    cache_.reset();
    cache_ = got(BlobCache::open(path(), max_bytes));
  }
  std::string path() const { return folder_ / "cache"; }
  std::string get(const std::string& text, const std::string& owner = "ann") {
    Source source{text, {}};
    const std::optional<Blob> blob = got(cache_->get(key_of(owner, text), source.fetch()));
    return blob ? text_of(*blob) : "none";
  }
  bool has(const std::string& text, const std::string& owner = "ann") {
    return got(cache_->get(key_of(owner, text), kNone)).has_value();
  }
  BlobCache* operator->() { return cache_.get(); }

  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(path())) {
      if (entry.is_regular_file()) found.push_back(entry.path());
    }
    return found;
  }

 private:
  TestFolder folder_;
  std::unique_ptr<BlobCache> cache_;
};

void overwrite(const fs::path& path, std::string_view text) { std::ofstream(path, std::ios::binary) << text; }

}  // namespace

TEST_CASE("blob cache: a blob is fetched once, then read from a file, also after a restart") {
  Cache cache;
  for (const std::string& text : {std::string(), std::string("x"), long_text(12'345)}) {
    CHECK_FALSE(cache.has(text));
    CHECK(cache.get(text) == text);
    CHECK(cache.has(text));
    CHECK_FALSE(cache.has(text, "bob"));
  }
  cache.reopen();
  CHECK(cache->counters().files == 3);
  CHECK(cache->counters().bytes == 12'346);
  CHECK(cache.has("x"));
  CHECK(cache->counters().hits == 1);
  cache->forget(key_of("ann", "x"));
  CHECK_FALSE(cache.has("x"));
  CHECK(cache.files().size() == 2);
}

TEST_CASE("blob cache: the least recently used are removed, and open blobs stay readable") {
  Cache cache(30'000);
  const std::string a = "a" + long_text(10'000), b = "b" + long_text(9'000), c = "c" + long_text(9'000);
  CHECK(cache.get(a) == a);
  CHECK(cache.get(b) == b);
  const std::optional<Blob> open = got(cache->get(key_of("ann", b), kNone));
  CHECK(cache.get(c) == c);
  CHECK(cache.has(a));
  const std::string d = "d" + long_text(9'000);
  CHECK(cache.get(d) == d);
  CHECK(cache.has(a));
  CHECK_FALSE(cache.has(b));
  CHECK(text_of(*open) == b);
  CHECK(cache.has(c));
  CHECK(cache->counters().bytes <= 30'000);
  CHECK(cache.files().size() == 3);
  const std::string large = long_text(40'000);
  CHECK(cache.get(large) == large);
  CHECK_FALSE(cache.has(large));
  CHECK(cache->counters().bytes <= 30'000);
}

TEST_CASE("blob cache: the order of use, and the budget, survive a restart") {
  Cache cache;
  const std::string a = "a" + long_text(1'000), b = "b" + long_text(1'000), c = "c" + long_text(1'000);
  for (const std::string& text : {a, b, c}) {
    CHECK(cache.get(text) == text);
    std::this_thread::sleep_for(15ms);
  }
  cache.reopen(2'500);
  CHECK_FALSE(cache.has(a));
  CHECK(cache.has(b));
  CHECK(cache.has(c));
  CHECK(cache.files().size() == 2);
}

TEST_CASE("blob cache: damaged files are refused and fetched again, whenever they were damaged") {
  const std::string text = long_text(5'000);
  for (const std::string& damage : {long_text(4'999), std::string(5'000, 'x'), std::string(), long_text(5'001)}) {
    for (const bool restart : {true, false}) {
      Cache cache;
      CHECK(cache.get(text) == text);
      REQUIRE(cache.files().size() == 1);
      overwrite(cache.files()[0], damage);
      if (restart) cache.reopen();
      CHECK(cache.get(text) == text);
      CHECK(cache->counters().refused == 1);
      CHECK(cache->counters().bytes == 5'000);
    }
  }
}

TEST_CASE("blob cache: leftovers of a killed process are removed, files of others are not") {
  Cache cache;
  CHECK(cache.get("x") == "x");
  overwrite(cache.path() + "/incoming/half", "half");
  overwrite(cache.path() + "/README", "mine");
  fs::create_symlink("/etc/passwd",
                     cache.files()[0].parent_path() / (std::string(64, 'a') + "." + std::string(64, 'b')));
  cache.reopen();
  CHECK_FALSE(fs::exists(cache.path() + "/incoming/half"));
  CHECK(fs::exists(cache.path() + "/README"));
  CHECK(cache->counters().files == 1);
  CHECK(cache.has("x"));
}

TEST_CASE("blob cache: neither bytes with another digest nor half a fetch are returned") {
  Cache cache;
  Source wrong{"wrong", {}};
  const Result<std::optional<Blob>> refused = cache->get(key_of("ann", "right"), wrong.fetch());
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::internal);
  CHECK(wrong.fetches == 2);
  CHECK(cache->counters().refused == 2);
  const Result<std::optional<Blob>> broken = cache->get(key_of("ann", "right"), [](const RemoteBlobs::Take& take) {
    static_cast<void>(take(bytes_of("rig")));
    return Result<bool>(Error{ErrorCode::storage_unavailable, "gone", "", ""});
  });
  REQUIRE_FALSE(broken.ok());
  CHECK(broken.error().code == ErrorCode::storage_unavailable);
  const auto thrown = cache->get(key_of("ann", "right"),
                                 [](const RemoteBlobs::Take&) -> Result<bool> { throw std::runtime_error("oh"); });
  CHECK_FALSE(thrown.ok());
  CHECK_FALSE(cache.has("right"));
  CHECK(cache.files().empty());
  CHECK(cache.get("right") == "right");
}

TEST_CASE("blob cache: concurrent readers share one fetch and its error") {
  Cache cache;
  const std::string text = long_text(50'000);
  Source source{text, {}};
  for (const bool fails : {true, false}) {
    std::atomic<int> fetches{0};
    std::atomic<int> right{0};
    {
      std::vector<std::jthread> threads;
      for (int i = 0; i < 8; ++i) {
        threads.emplace_back([&] {
          const auto blob = cache->get(key_of("ann", text), [&](const RemoteBlobs::Take& take) -> Result<bool> {
            ++fetches;
            std::this_thread::sleep_for(100ms);
            if (fails) return Error{ErrorCode::storage_unavailable, "down", "", ""};
            return source.fetch()(take);
          });
          if (fails ? !blob.ok() : blob.ok() && *blob && text_of(**blob) == text) ++right;
        });
      }
    }
    CHECK(right == 8);
    CHECK(fetches < 8);  // calls within a tenth of a second share one
    if (!fails) CHECK(fetches == 1);
  }
}

TEST_CASE("blob cache: many threads, more blobs than room") {
  Cache cache(20'000);
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 6; ++t) {
      threads.emplace_back([&, t] {
        for (int i = 0; i < 300; ++i) {
          const std::string text = std::to_string((i * 7 + t) % 13) + long_text(3'000);
          if (cache.get(text) != text) ++wrong;
          if (i % 50 == 0) cache->forget(key_of("ann", text));
        }
      });
    }
  }
  CHECK(wrong == 0);
  CHECK(cache->counters().bytes <= 20'000);
  std::uint64_t bytes = 0;
  for (const fs::path& file : cache.files()) bytes += fs::file_size(file);
  CHECK(bytes == cache->counters().bytes);
}
