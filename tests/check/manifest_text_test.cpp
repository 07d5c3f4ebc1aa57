#include "check/manifest/manifest_text.h"

#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

std::vector<Entry> entries(const std::string& text) {
  Mistakes mistakes;
  auto read = read_manifest(text, mistakes);
  for (const Mistake& mistake : std::move(mistakes).sorted()) FAIL_CHECK(to_string("f", mistake));
  return read;
}

// One gate, with more lines in it and in `defaults`.
Gate gate(const std::string& more, const std::string& defaults = "timeout: 30 s") {
  const auto read = entries("version: 1\ndefaults: {" + defaults +
                            "}\ngates:\n- {name: n, candidate: c, baseline: b, " + more + "}\n");
  REQUIRE(read.size() == 1);
  return read[0].gate;
}

}  // namespace

TEST_CASE("manifest text: defaults are those of the API, except the tolerance") {
  const Gate read = gate("max_distance: 2");
  CHECK(read.request.options.max_distance == 2.0);
  CHECK_FALSE(read.request.options.units.limit);
  CHECK(read.request.options.narrow);
  CHECK(read.request.options.direction == Direction::symmetric);
  CHECK(read.request.options.strategy == Strategy::automatic);
  CHECK(!read.request.options.tolerance.relative);  // a gate ends with its verdict
  CHECK(read.request.options.tolerance.diagonal == api::kToleranceOfGate.diagonal);
  CHECK(read.request.timeout.count() == 30'000);
  CHECK(!read.request.threads_given);
  CHECK(!read.warn_only);
  CHECK(!read.request.options.statistics);
  CHECK(!read.cloud);
  CHECK(read.line == 4);
}

TEST_CASE("manifest text: every setting arrives, from the gate and from the defaults") {
  const std::string all =
      "max_distance: 0.5 %, direction: baseline_to_candidate, timeout: 1.5, strategy: n_point, points: 109, "
      "tolerance: {absolute: 0, relative: 0.25}, threads: 7, statistics: true, cloud: true, on_fail: warn";
  for (const Gate& read : {gate(all), gate("max_distance: 0.5 %", all)}) {
    CHECK(read.request.options.max_distance == 0.005);
    CHECK(is_of_diagonal(read));
    CHECK(read.request.options.direction == Direction::b_to_a);
    CHECK(read.request.timeout.count() == 1'500);
    CHECK(read.request.options.strategy == Strategy::n_point);
    CHECK(read.request.options.points == 109);
    CHECK(read.request.options.tolerance.absolute == 0.0);
    CHECK(!read.request.options.tolerance.diagonal);
    CHECK(read.request.options.tolerance.relative == 0.25);
    CHECK(read.request.options.threads == 7);
    CHECK(read.request.threads_given);
    CHECK(read.request.options.statistics);
    CHECK(read.cloud);
    CHECK(read.warn_only);
  }
}

TEST_CASE("manifest text: a gate's own settings stand over the defaults") {
  const Gate read =
      gate("max_distance: 1 mm, direction: a_to_b, tolerance: {absolute: 1}, statistics: false, on_fail: fail",
           "max_distance: 5 %, direction: b_to_a, tolerance: {relative: 1}, statistics: true, on_fail: warn");
  CHECK(read.request.options.max_distance == 1.0);
  CHECK(read.request.options.units.limit == LengthUnit::millimeter);
  CHECK(!is_of_diagonal(read));
  CHECK(read.request.options.direction == Direction::a_to_b);
  CHECK(!read.request.options.tolerance.relative);
  CHECK(!read.request.options.statistics);
  CHECK(!read.warn_only);
}

TEST_CASE("manifest text: what a gate expects of its candidate") {
  CHECK(!gate("max_distance: 1").request.options.expect.of_topology());
  const Expectations expect =
      gate(
          "max_distance: 1, expect: {watertight: true, triangles: {max: 20000}, degenerate: 0, components: {min: 1, "
          "max: 3}, volume: {within: 1 %, min: 2}}")
          .request.options.expect;
  CHECK(expect.watertight == true);
  CHECK(!expect.oriented);
  CHECK(!expect.triangles->min);
  CHECK(expect.triangles->max == 20000);
  CHECK(expect.degenerate->min == 0);
  CHECK(expect.degenerate->max == 0);
  CHECK(expect.components->min == 1);
  CHECK(expect.components->max == 3);
  CHECK(expect.volume_within == 0.01);
  CHECK(expect.volume->min == 2);
  CHECK(!expect.volume->max);
  const Expectations own =
      gate("max_distance: 1, expect: {oriented: false}", "expect: {watertight: true}").request.options.expect;
  CHECK(own.oriented == false);
  CHECK(!own.watertight);  // a gate's own stand alone
  CHECK(gate("max_distance: 1", "expect: {components: 1}").request.options.expect.components->max == 1);
}

TEST_CASE("manifest text: the points of the defaults are for the gates that leave them their strategy") {
  CHECK(gate("max_distance: 1", "strategy: n_point, points: 31").request.options.points == 31);
  CHECK(gate("max_distance: 1, strategy: auto", "strategy: n_point, points: 31").request.options.strategy ==
        Strategy::automatic);
  CHECK(gate("max_distance: 1, points: 4", "strategy: n_point, points: 31").request.options.points == 4);
  CHECK(gate("max_distance: 1, strategy: n_point", "points: 31").request.options.points == 31);
  Mistakes mistakes;
  read_manifest(
      "version: 1\ndefaults: {points: 31, max_distance: 1}\ngates:\n- {name: n, candidate: c, baseline: b}\n"
      "- {name: m, candidate: c, baseline: b}\n",
      mistakes);
  const auto all = std::move(mistakes).sorted();
  REQUIRE(all.size() == 1);  // once, where it stands
  CHECK(all[0].line == 2);
  CHECK(all[0].message.find("points goes with the strategy n_point only") == 0);
}

TEST_CASE("manifest text: the defaults may stand below the gates") {
  const auto read = entries("gates: [{name: n, candidate: c, baseline: b}]\ndefaults: {max_distance: 3}\nversion: 1\n");
  REQUIRE(read.size() == 1);
  CHECK(read[0].gate.request.options.max_distance == 3.0);
}

TEST_CASE("manifest text: an unusable text is empty, the rest is read") {
  Mistakes mistakes;
  const auto read = read_manifest(
      "version: 1\ngates:\n- {name: '{', candidate: '[', baseline: '*', max_distance: 1}\n"
      "- {name: n, candidate: c, baseline: b, max_distance: x}\n- 5\n",
      mistakes);
  REQUIRE(read.size() == 2);
  CHECK(read[0].name.text.empty());
  CHECK(read[0].candidate.text.empty());
  CHECK(read[0].baseline.text.empty());
  CHECK(read[1].name.text == "n");
  CHECK(std::move(mistakes).sorted().size() == 5);
}

TEST_CASE("manifest text: the length of a text is limited") {
  Mistakes mistakes;
  const std::string rest = ", candidate: c, baseline: b, max_distance: 1}\n";
  read_manifest("version: 1\ngates:\n- {name: " + std::string(kMaxNameBytes, 'n') + rest, mistakes);
  CHECK(mistakes.empty());
  read_manifest("version: 1\ngates:\n- {name: " + std::string(kMaxNameBytes + 1, 'n') + rest, mistakes);
  const auto all = std::move(mistakes).sorted();
  REQUIRE(all.size() == 1);
  CHECK(all[0].message == "name must not be longer than 200 bytes");
}

TEST_CASE("manifest text: a limit of the area, alone or beside one of the distance") {
  const auto alone = gate("max_share_beyond: {distance: 0.05 mm, share: 1 %}").request.options;
  CHECK(!alone.max_distance);
  CHECK(alone.max_share_beyond == api::ShareLimit{0.05, 0.01});
  CHECK(alone.tolerance.relative == api::kToleranceOfArea.relative);
  const auto both =
      gate("max_share_beyond: {distance: 0.5 %, share: 0 %}, tolerance: {relative: 1}", "max_distance: 1 %")
          .request.options;
  CHECK(both.max_distance == 0.01);
  CHECK(both.max_share_beyond == api::ShareLimit{0.005, 0});
  CHECK(both.units.limit_of_diagonal);
  CHECK(both.tolerance.relative == 1);
  CHECK(gate("direction: a_to_b", "max_share_beyond: {distance: 2, share: 3 %}")
            .request.options.max_share_beyond->share == 0.03);
}

TEST_CASE("manifest text: regions of a gate replace those of the defaults") {
  const std::string one = "regions: [{name: bore, box: {min: [0, -1, 0], max: [1, 2, 3]}, max_distance: 0.5 %}]";
  const auto of_defaults = gate("max_distance: 1 %, " + one).request.options.regions;
  REQUIRE(of_defaults.size() == 1);
  CHECK(of_defaults[0].max_distance == 0.005);
  CHECK(std::get<Box>(of_defaults[0].shape).high == Vec3(1, 2, 3));
  const auto own = gate("regions: [{name: tip, sphere: {centre: [0, 0, 0], radius: 4}}]", "max_distance: 1 %, " + one)
                       .request.options.regions;
  REQUIRE(own.size() == 1);
  CHECK(own[0].name == "tip");
  CHECK(!own[0].max_distance);
}

TEST_CASE("manifest text: a zone, alone or beside other limits") {
  using Zone = SideOptions::Limits;
  const auto options = [](const std::string& more, const std::string& defaults = "timeout: 30 s") {
    return gate(more, defaults).request.options;
  };
  const auto alone = options("zone: [-0.05 mm, +0.1 mm]");
  CHECK(!alone.max_distance);
  CHECK(alone.zone == Zone{0.05, 0.1});
  CHECK(alone.units.limit == LengthUnit::millimeter);
  const auto shares = options("zone: ['-0.5 %', 1 %]", "max_distance: 1 %");
  CHECK(shares.zone == Zone{0.005, 0.01});
  CHECK(shares.units.limit_of_diagonal);
  CHECK(options("direction: a_to_b", "zone: [0, 2]").zone == Zone{0, 2});
  CHECK(options("zone: [-0.05 mm, 0]").units.limit == LengthUnit::millimeter);
  CHECK(options("zone: [0, 0.1 mm]").zone == Zone{0, 0.1});
  CHECK(options("zone: ['-1 %', 0]").zone == Zone{0.01, 0});
}

TEST_CASE("manifest text: an uncertainty is in the unit of the limits") {
  CHECK(gate("max_distance: 0.05 mm, uncertainty: 0.01 mm").request.options.uncertainty == 0.01);
  CHECK(gate("max_distance: 1 %", "uncertainty: 0.1 %").request.options.uncertainty == 0.001);
  CHECK(gate("max_distance: 1 %").request.options.uncertainty == 0);
}

TEST_CASE("manifest text: an alignment, as the API reads it") {
  CHECK_FALSE(gate("max_distance: 1").request.options.align);
  CHECK_FALSE(gate("max_distance: 1, align: none", "align: rigid").request.options.align);
  CHECK(gate("max_distance: 1", "align: rigid").request.options.align == AlignOptions());
  CHECK(gate("max_distance: 1, align: {principal_axes: true, overlap: 0.75}").request.options.align ==
        AlignOptions{{}, true, true, 0.75});
  const Gate moved = gate("max_distance: 1, align: {transform: {row_major: [1,0,0,5, 0,1,0,6, 0,0,1,-7, 0,0,0,1]}}");
  REQUIRE(moved.request.options.align);
  CHECK_FALSE(moved.request.options.align->fit);
  CHECK(moved.request.options.align->start.translation == Vec3(5, 6, -7));
}
