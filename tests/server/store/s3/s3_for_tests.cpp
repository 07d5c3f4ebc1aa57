#include "s3_for_tests.h"

#include <cstdlib>
#include <stdexcept>
#include <thread>

namespace meshgauge::server::store {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kMegabyte = 1'000'000;
constexpr std::uint64_t kCache = 6 * kMegabyte;  // less than the suite stores

std::optional<S3Settings> settings_of_environment() {
  const char* endpoint = std::getenv("MESHGAUGE_TEST_S3");
  if (endpoint == nullptr) return std::nullopt;
  const char* blobs = std::getenv("MESHGAUGE_TEST_S3_BLOBS");
  Result<S3Settings> settings = s3_settings(blobs == nullptr ? "" : blobs, endpoint, "us-east-1", false);
  if (!settings) throw std::runtime_error(settings.error().message);
  settings->prefix += (settings->prefix.empty() ? "" : "/") + ("test é+&" + api::random_id());
  return *settings;
}

}  // namespace

S3BlobOptions options_for_tests() {
  S3BlobOptions options;
  options.in_parts_from = 4 * kMegabyte;
  options.part_bytes = 1 << 20;
  options.young = 0s;
  return options;
}

S3Limits limits_for_tests() {
  S3Limits limits;
  limits.attempts = 4;
  limits.first_pause = 2ms;
  limits.longest_pause = 10ms;
  return limits;
}

S3Settings settings_for_tests(std::optional<S3Double>& server) {
  if (const auto settings = settings_of_environment()) return *settings;
  server.emplace();
  server->control("settings", {{"least_part", 1 << 20}});
  return server->settings();
}

S3ForTests::S3ForTests() : settings_(settings_for_tests(double_)) { reopen(); }

// Nothing stays on a real server.
S3ForTests::~S3ForTests() {
  if (!double_) static_cast<void>(blobs_->remove_unused({}, 0s));
}

void S3ForTests::reopen() {
  blobs_.reset();
  Result<std::unique_ptr<BlobCache>> cache = BlobCache::open(folder_ / "cache", kCache);
  if (!cache) throw std::runtime_error(cache.error().message);
  auto remote = std::make_unique<S3Blobs>(settings_, options_for_tests(), limits_for_tests());
  blobs_ = std::make_unique<CachedBlobs>(std::move(remote), std::move(*cache));
}

void S3ForTests::pass_time(std::chrono::milliseconds time) {
  const auto seen = std::chrono::ceil<std::chrono::seconds>(time) + 1s;
  if (double_) {
    double_->control("age", seen.count());
  } else {
    std::this_thread::sleep_for(seen + 1s);
  }
}

}  // namespace meshgauge::server::store
