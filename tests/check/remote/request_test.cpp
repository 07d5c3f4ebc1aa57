#include "check/remote/request.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/request.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

const std::string kA(64, 'a'), kB(64, 'b');

// What the service reads from it.
api::Request read(const Gate& gate, double max_distance) {
  const auto pair = api::parse_stored_pair(service::document_of(service::asked_of(kA, kB, gate, {max_distance, {}})));
  REQUIRE(pair.ok());
  CHECK(pair->a == kA);
  CHECK(pair->b == kB);
  auto request = api::parse_options(pair->options);
  REQUIRE(request.ok());
  return *request;
}

}  // namespace

TEST_CASE("request: the gate's settings are sent") {
  Gate gate;
  gate.limit.unit = LengthUnit::millimeter;
  gate.options.units = {LengthUnit::inch, LengthUnit::foot, {}, false};
  gate.timeout = std::chrono::milliseconds(1234);
  gate.options.direction = Direction::b_to_a;
  gate.options.strategy = Strategy::n_point;
  gate.options.points = 31;
  gate.options.tolerance = {0.5, 1e-7, std::nullopt};
  gate.options.threads = 3;
  gate.threads_given = true;
  gate.options.max_work_items = 77;
  gate.options.max_memory_bytes = std::size_t{3} << 20;
  gate.statistics = true;
  gate.options.align = AlignOptions{{}, true, true, 0.5};
  const auto request = read(gate, 0.1);
  CHECK(request.options.units == api::AskedUnits{LengthUnit::inch, LengthUnit::foot, LengthUnit::millimeter, false});
  CHECK(request.timeout == gate.timeout);
  CHECK(request.options.max_distance == 0.1);
  CHECK(request.options.direction == Direction::b_to_a);
  CHECK(request.options.strategy == Strategy::n_point);
  CHECK(request.options.points == 31);
  CHECK(request.options.tolerance.absolute == 0.5);
  CHECK(request.options.tolerance.diagonal == 1e-7);
  CHECK_FALSE(request.options.tolerance.relative);
  CHECK(request.options.threads == 3);
  CHECK(request.threads_given);
  CHECK(request.options.max_work_items == 77);
  CHECK(request.options.max_memory_bytes == std::size_t{3} << 20);
  CHECK(request.options.statistics.has_value());
  CHECK(request.options.align == gate.options.align);
  CHECK_FALSE(request.options.expect.any());
  gate.expect.triangles = Span{1, 2};
  gate.expect.volume_within = 0.01;
  CHECK(read(gate, 0.1).options.expect == gate.expect);
}

TEST_CASE("request: settings that the gate does not have are left to the service") {
  const Gate gate;
  const auto request = read(gate, 0);
  CHECK_FALSE(request.threads_given);
  CHECK(request.options.units == api::AskedUnits{});
  CHECK(request.options.tolerance.diagonal == gate.options.tolerance.diagonal);
  CHECK_FALSE(request.options.statistics.has_value());
  const auto json = nlohmann::json::parse(service::document_of(service::asked_of(kA, kB, gate, {0, {}})));
  for (const char* absent : {"threads", "budget", "points", "statistics", "topology", "expect"})
    CHECK_FALSE(json["options"].contains(absent));
}

TEST_CASE("request: a share of the diagonal is a number in the unit of the baseline") {
  Gate gate;
  gate.limit = {std::nullopt, 0.005, std::nullopt};
  CHECK(read(gate, 0.1).options.units.limit_of_b);
}

TEST_CASE("request: the limit arrives bit by bit") {
  for (const double limit : {0.1, 1.0 / 3, 5e-324, 1.7976931348623157e308, 0.012345678901234567}) {
    CHECK(read({}, limit).options.max_distance == limit);
  }
}

TEST_CASE("request: a limit of the area is sent, and asks little of the distance") {
  Gate gate;
  gate.area_limit = AreaLimit{{0.1, {}, LengthUnit::millimeter}, 0.01};
  const auto read = [&] {
    const auto asked = service::asked_of(kA, kB, gate, limits_of(gate, 0));
    return api::parse_options(api::parse_stored_pair(service::document_of(asked))->options);
  };
  REQUIRE(read().ok());
  CHECK(!read()->options.max_distance);
  CHECK(read()->options.max_share_beyond == api::ShareLimit{0.1, 0.01});
  CHECK(read()->options.units.limit == LengthUnit::millimeter);
  CHECK(read()->options.narrow);
  CHECK(read()->options.tolerance.relative == kToleranceOfArea.relative);
  gate.limit = {0.5, {}, LengthUnit::millimeter};
  gate.uncertainty = {0.05, {}, LengthUnit::millimeter};
  CHECK(read()->options.uncertainty == 0.05);
  CHECK(read()->options.max_distance == 0.5);
  CHECK(read()->options.regions.empty());
  gate.regions = {{{Sphere{Vec3(1, 2, 3), 4}, {}, "tip"}, {0.25, {}, LengthUnit::millimeter}}};
  REQUIRE(read()->options.regions.size() == 1);
  CHECK(read()->options.regions[0].name == "tip");
  CHECK(read()->options.regions[0].max_distance == 0.25);
  CHECK(std::get<Sphere>(read()->options.regions[0].shape).centre == Vec3(1, 2, 3));
  CHECK(read()->options.tolerance.diagonal == gate.options.tolerance.diagonal);
}
