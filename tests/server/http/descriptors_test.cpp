#include "server/http/descriptors.h"

#include <doctest/doctest.h>

using namespace meshgauge::server;

TEST_CASE("descriptors: connections get three quarters, less where the settings need more, and none below a least") {
  Settings settings;
  settings.workers = 2;
  settings.parsers = 3;
  const DescriptorPlan usual = planned(settings, 1024);
  CHECK(usual.needed == 5 * (2 + 16) + 6 * 3 + 100);
  CHECK(usual.connections == 768);
  CHECK(planned(settings, 10'000'000).connections == 100'000);
  CHECK(planned(settings, 400).connections == 400 - usual.needed);
  CHECK(planned(settings, usual.needed + 64).connections == 64);
  CHECK(planned(settings, usual.needed + 63).connections == 0);
  CHECK(planned(settings, 0).connections == 0);
  settings.status_port = 8081;
  CHECK(planned(settings, 1024).needed == usual.needed + kStatusConnections);
  CHECK(planned(settings, usual.needed + kStatusConnections + 64).connections == 64);
  settings.queue = 4096;
  CHECK(planned(settings, 1024).connections == 0);
}
