#include "server/settings/settings.h"

#include <doctest/doctest.h>

#include "engine/hausdorff.h"
#include "server/main/checked.h"

using namespace meshgauge;
using server::checked;
using server::plan_memory;
using server::Settings;

namespace {

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;

Settings planned(std::uint64_t machine, bool tmpfs, std::uint64_t workers, Settings settings = {}) {
  settings.workers = workers;
  plan_memory({machine, tmpfs}, settings);
  return settings;
}

}  // namespace

TEST_CASE("settings: the defaults are consistent") {
  const auto settings = checked(Settings{});
  REQUIRE(settings.ok());
  CHECK(settings->workers >= 1);
  CHECK(settings->simd == supported_simd().front());
  CHECK(settings->parsers == settings->workers + 1);
  CHECK(settings->handshake_threads >= 1);
}

TEST_CASE("settings: a parser's memory is derived from the limits on files, unless it is set") {
  Settings settings;
  settings.max_vertices = 1'000'000;
  settings.max_triangles = 2'000'000;
  settings.max_expanded_bytes = 3'000'000;
  CHECK(checked(settings)->parser_memory_bytes == 3'000'000 + 2 * 48'000'000 + (256 << 20));
  settings.parser_memory_bytes = 100'000'000;
  CHECK(checked(settings)->parser_memory_bytes == 100'000'000);
  settings.parser_memory_bytes = 0;
  settings.max_vertices = settings.max_triangles = settings.max_expanded_bytes = ~std::uint64_t{0};
  CHECK(checked(settings).ok());
}

TEST_CASE("settings: an instruction set can be forced, and must be one of this processor's") {
  Settings settings;
  settings.simd = "scalar";
  CHECK(checked(settings)->simd == "scalar");
  settings.simd = "abacus";
  const auto refused = checked(settings);
  REQUIRE(!refused.ok());
  CHECK(refused.error().message.starts_with("--simd must be one of auto, "));
}

TEST_CASE("settings: contradictions and impossible values are refused") {
  const auto refused = [](auto change) {
    Settings settings;
    settings.workers = 2;
    change(settings);
    return !checked(settings).ok();
  };
  CHECK(!refused([](Settings&) {}));
  CHECK(refused([](Settings& s) { s.port = 65536; }));
  CHECK(refused([](Settings& s) { s.queue = ~std::uint64_t{0}; }));
  CHECK(refused([](Settings& s) { s.io_threads = 1'000'000; }));
  CHECK(refused([](Settings& s) { s.io_threads = 0; }));
  CHECK(refused([](Settings& s) { s.status_port = 70'000; }));
  CHECK(refused([](Settings& s) { s.handshake_threads = 5000; }));
  CHECK(refused([](Settings& s) { s.max_handshakes_per_second = 0; }));
  CHECK(refused([](Settings& s) { s.max_handshakes_per_second_per_peer = 0; }));
  CHECK(refused([](Settings& s) { s.max_handshakes_per_second_per_peer = 1'000'001; }));
  CHECK(refused([](Settings& s) { s.max_timeout_ms = 180'001; }));
  CHECK(refused([](Settings& s) { s.default_timeout_ms = 180'000, s.max_timeout_ms = 1000; }));
  CHECK(refused([](Settings& s) { s.default_timeout_ms = 0; }));
  CHECK(refused([](Settings& s) { s.grace_ms = ~std::uint64_t{0}; }));
  CHECK(refused([](Settings& s) { s.parsers = 5000; }));
  CHECK(refused([](Settings& s) { s.parser_memory_bytes = 1000; }));
  CHECK(refused([](Settings& s) { s.parser_memory_bytes = ~std::uint64_t{0}; }));
  CHECK(refused([](Settings& s) { s.tls_certificate = "c.pem"; }));
  CHECK(refused([](Settings& s) { s.tls_key = "k.pem"; }));
  CHECK(refused([](Settings& s) { s.cors_origins = "*"; }));
  CHECK(refused([](Settings& s) { s.max_part_bytes = s.max_request_bytes + 1; }));
}

TEST_CASE("settings: a database selects the distributed form, whose settings are validated") {
  const auto with = [](auto change) {
    Settings settings;
    settings.workers = 2;
    settings.database = "postgresql://meshgauge@one,two/meshgauge";
    change(settings);
    return checked(settings);
  };
  CHECK(!server::is_distributed(Settings{}));
  CHECK(server::is_distributed(*with([](Settings&) {})));
  CHECK(with([](Settings& s) { s.database = "host=one,two port=5432 dbname=x password='a b'"; }).ok());
  CHECK(with([](Settings& s) { s.blobs = "s3://a-bucket/a/prefix", s.s3_endpoint = "http://127.0.0.1:9000"; }).ok());
  CHECK(with([](Settings& s) { s.heartbeat_ms = 100, s.lease_ms = 200; }).ok());
  for (const char* bucket : {"a-bucket", "s3:/a-bucket", "s3://", "s3:///x", "s3://A_b/x", "https://a-bucket"}) {
    CHECK_FALSE_MESSAGE(with([&](Settings& s) { s.blobs = bucket; }).ok(), bucket);
  }
  CHECK(!with([](Settings& s) { s.database = "", s.blobs = "s3://bucket"; }).ok());
  CHECK(!with([](Settings& s) { s.s3_endpoint = "127.0.0.1:9000"; }).ok());
  CHECK(!with([](Settings& s) { s.s3_region = ""; }).ok());
  CHECK(!with([](Settings& s) { s.heartbeat_ms = 0; }).ok());
  CHECK(!with([](Settings& s) { s.heartbeat_ms = 1000, s.lease_ms = 1999; }).ok());
  CHECK(!with([](Settings& s) { s.lease_ms = ~std::uint64_t{0}; }).ok());
  CHECK(!with([](Settings& s) { s.max_batch_pairs = 0; }).ok());
  CHECK(!with([](Settings& s) { s.max_batch_pairs = 1'000'000; }).ok());
}

TEST_CASE("settings: a message about a connection string does not show it") {
  Settings settings;
  settings.database = "host=one password=a secret";
  const auto refused = checked(settings);
  REQUIRE(!refused.ok());
  CHECK(refused.error().message.find("--database must be") != std::string::npos);
  CHECK(refused.error().message.find("secret") == std::string::npos);
}

TEST_CASE("memory plan: all parts together fit into the machine, whatever it has") {
  for (const std::uint64_t machine : {kGiB / 2, kGiB, 4 * kGiB, 16 * kGiB, 256 * kGiB}) {
    for (const std::uint64_t workers : {1U, 2U, 8U, 64U}) {
      for (const bool tmpfs : {false, true}) {
        const Settings s = planned(machine, tmpfs, workers);
        CHECK(s.max_memory_bytes + s.max_cache_bytes + (tmpfs ? s.max_upload_bytes : 0) < machine);
        CHECK(s.max_memory_bytes >= machine / 4);
        CHECK(s.parser_memory_bytes <= s.max_memory_bytes / 2);
        CHECK(server::memory_for_meshes(s) >= s.max_memory_bytes / 4 * 3);
      }
    }
  }
}

TEST_CASE("memory plan: a large machine gets the defaults, and what is set stays where there is room") {
  const Settings large = planned(256 * kGiB, false, 8);
  CHECK(large.max_cache_bytes == Settings{}.max_cache_bytes);
  CHECK(large.max_upload_bytes == Settings{}.max_upload_bytes);
  CHECK(large.max_heap_bytes == Settings{}.max_heap_bytes);
  CHECK(large.parser_memory_bytes == 2 * kGiB + 2 * 50'000'000 * 36ULL + kGiB / 4);
  Settings set;
  set.max_memory_bytes = 300'000'000;
  set.parser_memory_bytes = 100'000'000;
  set.max_heap_bytes = 1'000'000;
  const Settings kept = planned(4 * kGiB, false, 2, set);
  CHECK(kept.max_memory_bytes == 300'000'000);
  CHECK(kept.parser_memory_bytes == 100'000'000);
  CHECK(kept.max_heap_bytes == 1'000'000);
}
