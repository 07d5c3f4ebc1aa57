// The cost of blobs in S3: s3_bench against the double, or within with_ceph.py or with_swift.py against a real server.
// Prints a table.
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

#include "../store_text.h"
#include "s3_for_tests.h"

using namespace meshgauge::server::store;
using Clock = std::chrono::steady_clock;

namespace {

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

void say(const char* what, double figure, const char* unit) { std::printf("%-58s %10.1f %s\n", what, figure, unit); }

std::string numbered(int number, std::size_t size) {
  std::string text = long_text(size);
  text.replace(0, 8, (std::to_string(number) + "        ").substr(0, 8));
  return text;
}

// Calls work(0) ... work(count - 1) on several threads; returns the calls a second.
template <class Work>
double rate(int threads, int count, Work work) {
  std::atomic<int> next{0};
  const Clock::time_point begin = Clock::now();
  {
    std::vector<std::jthread> all;
    for (int t = 0; t < threads; ++t) {
      all.emplace_back([&] {
        for (int i = next++; i < count; i = next++) work(i);
      });
    }
  }
  return count / seconds_since(begin);
}

void small_ones(BlobStore& blobs) {
  constexpr int kCount = 200;
  std::vector<std::string> texts;
  std::vector<BlobKey> keys;
  for (int i = 0; i < 2 * kCount; ++i) {
    texts.push_back(numbered(i, 50'000));
    keys.push_back(key_of("ann", texts.back()));
  }
  const auto put = [&](int i) {
    got(blobs.put(keys[static_cast<std::size_t>(i)], bytes_of(texts[static_cast<std::size_t>(i)])));
  };
  const auto open = [&](int i) { got(blobs.open(keys[static_cast<std::size_t>(i)])); };
  say("put() of 50 kB, 1 caller", rate(1, kCount, put), "/s");
  say("put() of 50 kB, 8 callers", rate(8, kCount, [&](int i) { put(i + kCount); }), "/s");
  say("put() of 50 kB that is there, 8 callers", rate(8, kCount, put), "/s");
  say("renew(), 8 callers", rate(8, kCount, [&](int i) { got(blobs.renew(keys[static_cast<std::size_t>(i)])); }), "/s");
  say("open() that is fetched, 8 callers", rate(8, kCount, open), "/s");
  say("open() from the cache, 1 caller", rate(1, kCount, open), "/s");
  Clock::time_point begin = Clock::now();
  got(blobs.stored_bytes("ann"));
  say("stored_bytes() of 400, first", 1000 * seconds_since(begin), "ms");
  say("stored_bytes() again", rate(1, 100'000, [&](int) { got(blobs.stored_bytes("ann")); }), "/s");
  begin = Clock::now();
  const std::uint64_t removed = got(blobs.remove_unused({}, std::chrono::seconds(0)));
  say("remove_unused(), each", 1000 * seconds_since(begin) / static_cast<double>(removed), "ms");
}

void a_large_one(BlobStore& blobs, unsigned parts_at_once) {
  const std::string text = long_text(200'000'000);
  const BlobKey key = key_of("ann", text);
  const std::string what = "put() of 200 MB, in parts of 32 MiB, " + std::to_string(parts_at_once) + " at once";
  Clock::time_point begin = Clock::now();
  got(blobs.put(key, bytes_of(text)));
  say(what.c_str(), 200 / seconds_since(begin), "MB/s");
  begin = Clock::now();
  got(blobs.open(key));
  say("open() of 200 MB, fetched", 200 / seconds_since(begin), "MB/s");
  begin = Clock::now();
  got(blobs.open(key));
  say("open() of 200 MB, from the cache", 1e6 * seconds_since(begin), "us");
  got(blobs.remove(key));
}

struct Stores {
  explicit Stores(unsigned parts_at_once = S3BlobOptions().parts_at_once) {
    S3BlobOptions options;
    options.young = std::chrono::seconds(0);
    options.parts_at_once = parts_at_once;
    auto remote = std::make_unique<S3Blobs>(settings_for_tests(server), options, S3Limits{});
    blobs.emplace(std::move(remote), got(BlobCache::open(folder / "cache", 1'000'000'000)));
  }

  const TestFolder folder;
  std::optional<S3Double> server;
  std::optional<CachedBlobs> blobs;
};

}  // namespace

TEST_CASE("S3: what small blobs cost") {
  Stores stores;
  small_ones(*stores.blobs);
}

TEST_CASE("S3: what a large blob costs") {
  for (const unsigned parts_at_once : {1U, 4U, 1U, 4U}) {
    Stores stores(parts_at_once);
    a_large_one(*stores.blobs, parts_at_once);
  }
}
