// Each limit and expectation is a criterion, once; the worst verdict counts, and the foremost is shown.
#include "api/result/criteria.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/result/examination.h"

using namespace meshgauge;
using api::Criterion;

namespace {

Directed one_way(double lower, double upper, double x) {
  Directed made;
  made.bounds = {lower, upper, Witness{{x, 0, 0}, 3, {x, 1, 0}, 4}};
  return made;
}

RegionOutcome region(double lower, double upper) {
  RegionOutcome made;
  made.empty = false;
  made.lower = lower;
  made.upper = upper;
  made.a_to_b = Bounds{lower, upper, Witness{{7, 0, 0}, 1, {7, 1, 0}, 2}};
  return made;
}

// With a limit of each kind: in a region "bore", for the rest, on both sides, of the area.
struct Everything {
  api::ComparisonOptions options;
  Outcome outcome;

  Everything() {
    options.max_distance = 0.5;
    options.uncertainty = 0.125;
    options.zone = SideOptions::Limits{1, 2};
    options.max_share_beyond = {0.25, 0.125};
    Region bore;
    bore.name = "bore";
    bore.max_distance = 0.25;
    options.regions = {bore};
    outcome.regions = {region(0.1, 0.2), region(0.3, 0.35)};
    SideOutcome& sides = outcome.sides.emplace();
    sides.inside = {0.5, 0.75, Vec3(1, 2, 3), 9};
    sides.outside = {2.5, 3, std::nullopt, 0};
    AreaOutcome& areas = outcome.areas.emplace();
    areas.a_to_b.emplace().beyond = {{0.1, 0.2}, {0.05, 0.1}};
    areas.a_to_b->stop = AreaStop::timeout;
    options.direction = Direction::a_to_b;
  }
};

}  // namespace

TEST_CASE("criteria: one for each limit, in the order of the request") {
  const Everything all;
  const auto criteria = api::criteria_of(all.outcome, all.options);
  std::vector<std::string> names;
  for (const Criterion& one : criteria) names.push_back(one.name);
  CHECK(names == std::vector<std::string>{"distance outside of all regions", "distance inside", "distance outside",
                                          "distance in bore", "share beyond"});
  CHECK(criteria[0].limit == 0.5);
  CHECK(criteria[0].region == "rest");
  CHECK_FALSE(criteria[0].is_of_region());
  CHECK(criteria[0].verdict == api::Verdict::pass);
  CHECK(criteria[1].side == "inside");
  REQUIRE(criteria[1].at);
  CHECK(criteria[1].at->triangle == 9);
  CHECK_FALSE(criteria[1].at->nearest);
  CHECK(criteria[2].verdict == api::Verdict::fail);
  CHECK_FALSE(criteria[2].at);
  CHECK(criteria[3].limit == 0.25);
  CHECK(criteria[3].verdict == api::Verdict::undecided);  // 0.2 > 0.25 - 0.125
  CHECK(criteria[4].lower == 0.05);                       // beyond 0.25 + 0.125
  CHECK(criteria[4].upper == 0.2);                        // beyond 0.25 - 0.125
  CHECK(criteria[4].status == "timeout");
  CHECK(criteria[4].verdict == api::Verdict::undecided);
  CHECK(api::worst(criteria) == api::Verdict::fail);
  CHECK(api::foremost(criteria).name == "distance outside");
}

TEST_CASE("criteria: none without a limit, and the witness is of the direction that attains the distance") {
  Outcome outcome;
  CHECK(api::criteria_of(outcome, {}).empty());
  CHECK(!api::worst({}));
  api::ComparisonOptions options;
  options.max_distance = 1;
  outcome.lower = 2;
  outcome.upper = 3;
  outcome.a_to_b = one_way(1, 2, 10);
  outcome.b_to_a = one_way(2, 3, 20);
  const auto criteria = api::criteria_of(outcome, options);
  REQUIRE(criteria.size() == 1);
  REQUIRE(criteria[0].at);
  CHECK_FALSE(criteria[0].at->on_a);
  CHECK(criteria[0].at->point.x() == 20);
  CHECK(criteria[0].name == "distance");
}

TEST_CASE("criteria: a mesh without sides leaves both sides of a zone undecided, and says why") {
  Everything all;
  all.outcome.sides->refused = NoSides{NoSides::Why::open, Vec3(1, 2, 3)};
  const auto criteria = api::criteria_of(all.outcome, all.options, api::LengthUnit::millimeter);
  for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
    CHECK(criteria[i].verdict == api::Verdict::undecided);
    CHECK(criteria[i].refused == "mesh b is open: an edge at (1, 2, 3) mm has one triangle");
    CHECK(api::finding_of(criteria[i], "mm") == "nothing is inside or outside: " + criteria[i].refused);
    CHECK(criteria[i].upper == std::numeric_limits<double>::infinity());
  }
}

TEST_CASE("criteria: the foremost has the worst verdict, and comes first in shares of its limit") {
  const auto of = [](double lower, double upper, double limit) {
    Criterion made;
    made.lower = lower;
    made.upper = upper;
    made.limit = limit;
    return api::judged(made);
  };
  Criterion unmet;
  unmet.of = Criterion::Of::expectation;
  unmet.name = "watertight";
  unmet.verdict = api::Verdict::fail;
  const auto at = [](const std::vector<Criterion>& all) { return &api::foremost(all) - all.data(); };
  CHECK(at({of(0, 0.1, 1), of(0, 0.9, 1), of(0, 1, 2)}) == 1);
  CHECK(at({of(2, 3, 1), of(0, 9, 1), of(4, 4, 1)}) == 2);
  CHECK(at({of(0, 0.1, 1), unmet}) == 1);
  CHECK(at({of(2, 3, 1), unmet}) == 0);
  CHECK(at({of(0, 0, 0), of(0, 0.5, 1)}) == 1);
  CHECK(at({of(1e-300, 1, 0), of(2, 2, 1)}) == 0);  // a limit of 0 is exceeded beyond all measure
}

TEST_CASE("criteria: the place to look at is of a limit that is not kept, though a share without a place comes first") {
  Everything all;
  all.outcome.areas->a_to_b->beyond = {{0.9, 1}, {0.9, 1}};
  const auto criteria = api::criteria_of(all.outcome, all.options);
  CHECK(api::foremost(criteria).name == "share beyond");
  CHECK(api::foremost_place(criteria) == nullptr);  // the point outside is not known
  all.outcome.sides->outside.at = Vec3(4, 5, 6);
  const auto located = api::criteria_of(all.outcome, all.options);
  REQUIRE(api::foremost_place(located));
  CHECK(api::foremost_place(located)->side == "outside");
}

TEST_CASE("criteria: sentences with few digits, each number on its side of the limit") {
  const Everything all;
  const auto criteria = api::criteria_of(all.outcome, all.options);
  CHECK(api::finding_of(criteria[0], "mm") ==
        "the distance outside of all regions is at most 0.35 mm, within the limit of 0.5 mm \xC2\xB1 0.125 mm");
  CHECK(api::finding_of(criteria[2], "") ==
        "the distance outside is at least 2.5, above the limit of 2 \xC2\xB1 0.125");
  CHECK(
      api::finding_of(criteria[2], "", "0.3 % of the diagonal").ends_with("above the limit of 0.3 % of the diagonal"));
  CHECK(api::finding_of(criteria[4], "mm") ==
        "between 4.999 and 20.01 % of the area is farther than 0.25 mm \xC2\xB1 0.125 mm: whether at most 12.5 % are "
        "is not "
        "known (timeout)");
  CHECK(api::finding_of(api::expectation("triangles", api::Verdict::fail, "12", "at most 10"), "") ==
        "triangles: 12, expected at most 10");
}

TEST_CASE("criteria: what is written is read back, and its verdict is that of the interval") {
  const Everything all;
  for (const Criterion& one : api::criteria_of(all.outcome, all.options)) {
    CAPTURE(one.name);
    auto json = api::json_of(one, "mm");
    json["verdict"] = "pass";
    const auto read = api::read_criterion(json);
    REQUIRE(read.ok());
    CHECK(read->verdict == one.verdict);
    CHECK(read->name == one.name);
    CHECK(read->at.has_value() == one.at.has_value());
    json["verdict"] = to_string(one.verdict);
    CHECK(api::json_of(*read, "mm") == json);
  }
  auto json = api::json_of(api::criteria_of(all.outcome, all.options).back(), "mm");
  for (const char* text :
       {R"({"lower":-1})", R"({"upper":2})", R"({"lower":0.5,"upper":0.25})", R"({"of":"mass"})", R"({"limit":null})",
        R"({"refused":"x"})", R"({"beyond":null})", R"({"status":3})", R"({"witness":{}})"}) {
    CAPTURE(text);
    auto wrong = json;
    wrong.update(nlohmann::ordered_json::parse(text));
    CHECK_FALSE(api::read_criterion(wrong).ok());
  }
  CHECK_FALSE(api::read_criterion(nlohmann::ordered_json::array()).ok());
  const nlohmann::ordered_json document{{"criteria", {json, 3, nullptr}}};
  CHECK(api::read_criteria(document).size() == 1);
  CHECK(api::read_criteria(nlohmann::ordered_json::object()).empty());
}

TEST_CASE("criteria: the foremost comes first, the others keep their order") {
  const Everything all;
  const auto criteria = api::foremost_first(api::criteria_of(all.outcome, all.options));
  std::vector<std::string> names;
  for (const Criterion& one : criteria) names.push_back(one.name);
  CHECK(names == std::vector<std::string>{"distance outside", "distance outside of all regions", "distance inside",
                                          "distance in bore", "share beyond"});
  CHECK(api::foremost_first({}).empty());
}

TEST_CASE("criteria: what a gate says of all its limits is written beside them and read back") {
  const Everything all;
  const Criterion first = api::criteria_of(all.outcome, all.options).front();
  CHECK(api::terms_json(first).dump() == R"({"uncertainty":0.125})");
  CHECK(api::terms_in(api::terms_json(first)).uncertainty == 0.125);
  CHECK(api::terms_json({}).dump() == "{}");
  for (const char* text : {"{}", R"({"uncertainty":"1"})", R"({"uncertainty":null})"})
    CHECK(api::terms_in(nlohmann::ordered_json::parse(text)).uncertainty == 0);
}
