#include "api/options/gate.h"

#include <doctest/doctest.h>

using namespace meshgauge;

TEST_CASE("gate: its question stands behind those of the request") {
  api::ComparisonOptions options;
  CHECK(!api::engine_options(options).areas);
  options.areas.emplace().beyond = {{3, {}}};
  options.max_share_beyond = {1, 0.5};
  const auto beyond = api::engine_options(options).areas->beyond;
  REQUIRE(beyond.size() == 2);
  CHECK(!beyond[0].max_share);
  CHECK(beyond[1].distance == 1);
  CHECK(beyond[1].max_share == 0.5);
}

TEST_CASE("gate: an uncertainty moves the distance of the area both ways") {
  api::ComparisonOptions options;
  options.max_share_beyond = {1, 0.5};
  options.uncertainty = 0.25;
  const auto beyond = api::engine_options(options).areas->beyond;
  REQUIRE(beyond.size() == 2);
  CHECK(beyond[0].distance == 0.75);
  CHECK(beyond[1].distance == 1.25);
}

TEST_CASE("gate: the engine is asked for the sides of a zone") {
  api::ComparisonOptions options;
  options.zone = {1, 2};
  CHECK(api::engine_options(options).sides->limits == options.zone);
}

TEST_CASE("gate: an uncertainty above a limit does not fit") {
  api::ComparisonOptions options;
  options.max_distance = 2;
  options.uncertainty = 0.5;
  CHECK(api::uncertainty_fits(options));
  options.uncertainty = 2.5;
  CHECK(!api::uncertainty_fits(options));
  options.max_distance.reset();
  options.zone = {1, 2};
  CHECK(!api::uncertainty_fits(options));
  options.uncertainty = 1.5;
  CHECK(!api::uncertainty_fits(options));
  options.uncertainty = 0.5;
  CHECK(api::uncertainty_fits(options));
}
