#include "server/settings/memory_plan.h"

#include <doctest/doctest.h>

using namespace meshgauge;
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
