#include "api/result/verdict.h"

#include <doctest/doctest.h>

#include "api/result/criteria.h"

using namespace meshgauge;

namespace {

api::Verdict judge(double lower, double upper, double limit) {
  Outcome outcome;
  outcome.lower = lower;
  outcome.upper = upper;
  api::ComparisonOptions options;
  options.max_distance = limit;
  return api::worst(api::criteria_of(outcome, options)).value();
}

}  // namespace

TEST_CASE("verdict: the interval decides") {
  CHECK(judge(0, 1, 2) == api::Verdict::pass);
  CHECK(judge(0, 2, 2) == api::Verdict::pass);  // at most
  CHECK(judge(3, 4, 2) == api::Verdict::fail);
  CHECK(judge(1, 3, 2) == api::Verdict::undecided);
  CHECK(judge(2, 3, 2) == api::Verdict::undecided);  // exactly 2 would pass
  CHECK(judge(0, 0, 0) == api::Verdict::pass);
}

TEST_CASE("verdict: no gate, no verdict") { CHECK(!api::worst(api::criteria_of(Outcome{}, {}))); }

namespace {

Outcome with_shares(const AreaInterval& a_to_b, const std::optional<AreaInterval>& b_to_a) {
  Outcome outcome;
  outcome.upper = 5;
  auto& areas = outcome.areas.emplace();
  areas.a_to_b.emplace().beyond = {{0, 1}, a_to_b};  // the gate's is the last
  if (b_to_a) areas.b_to_a.emplace().beyond = {{0, 1}, *b_to_a};
  return outcome;
}

}  // namespace

TEST_CASE("verdict: the share of the direction where it is largest") {
  api::ComparisonOptions options;
  options.max_share_beyond = {1, 0.5};
  const auto judge = [&](const AreaInterval& a, const std::optional<AreaInterval>& b = std::nullopt) {
    options.direction = b ? Direction::symmetric : Direction::a_to_b;
    return api::worst(api::criteria_of(with_shares(a, b), options)).value();
  };
  CHECK(judge({0, 0.5}) == api::Verdict::pass);
  CHECK(judge({0, 0.5}, AreaInterval{0.2, 0.4}) == api::Verdict::pass);
  CHECK(judge({0, 0.5}, AreaInterval{0.5, 0.6}) == api::Verdict::undecided);
  CHECK(judge({0, 0.5}, AreaInterval{0.51, 0.6}) == api::Verdict::fail);
  CHECK(judge({0.51, 1}) == api::Verdict::fail);
  options.max_distance = 4;  // in [0, 5]
  CHECK(judge({0, 0.5}) == api::Verdict::undecided);
  CHECK(judge({0.51, 1}) == api::Verdict::fail);
}

TEST_CASE("verdict: a share that is not known is undecided") {
  api::ComparisonOptions options;
  options.max_share_beyond = {1, 0.5};
  CHECK(api::worst(api::criteria_of(Outcome{}, options)) == api::Verdict::undecided);
  CHECK(api::limits_asked(options).front().lower == 0);
  CHECK(api::limits_asked(options).front().upper == 1);
  CHECK(api::worst(api::criteria_of(with_shares({0, 0.1}, std::nullopt), options)) == api::Verdict::undecided);
  CHECK(api::worst(api::criteria_of(with_shares({0.6, 0.7}, std::nullopt), options)) == api::Verdict::fail);
  options.direction = Direction::b_to_a;
  CHECK(api::worst(api::criteria_of(with_shares({0, 0.1}, std::nullopt), options)) == api::Verdict::undecided);
  options.direction = Direction::a_to_b;
  CHECK(api::worst(api::criteria_of(with_shares({0, 0.1}, std::nullopt), options)) == api::Verdict::pass);
}

TEST_CASE("verdict: a zone passes when both sides do, and is undecided without sides") {
  Outcome outcome;
  api::ComparisonOptions options;
  options.zone = {1, 2};
  CHECK(api::worst(api::criteria_of(outcome, options)) == api::Verdict::undecided);
  const auto judge = [&](std::pair<double, double> inside, std::pair<double, double> outside) {
    SideOutcome& sides = outcome.sides.emplace();
    sides.inside.lower = inside.first, sides.inside.upper = inside.second;
    sides.outside.lower = outside.first, sides.outside.upper = outside.second;
    return api::worst(api::criteria_of(outcome, options)).value();
  };
  CHECK(judge({0, 1}, {1.5, 2}) == api::Verdict::pass);
  CHECK(judge({0, 1.1}, {1.5, 2}) == api::Verdict::undecided);
  CHECK(judge({1.1, 1.2}, {1.5, 2}) == api::Verdict::fail);
  CHECK(judge({0, 1.1}, {2.1, 3}) == api::Verdict::fail);
  options.uncertainty = 0.5;
  CHECK(judge({0, 0.5}, {1, 1.5}) == api::Verdict::pass);
  CHECK(judge({0, 0.6}, {1, 1.5}) == api::Verdict::undecided);
  CHECK(judge({1.2, 1.5}, {1, 1.5}) == api::Verdict::undecided);
  CHECK(judge({1.6, 1.7}, {1, 1.5}) == api::Verdict::fail);
  outcome.sides->refused = NoSides{};
  CHECK(api::worst(api::criteria_of(outcome, options)) == api::Verdict::undecided);
}

TEST_CASE("verdict: an uncertainty narrows pass and fail") {
  Outcome outcome;
  api::ComparisonOptions options;
  options.max_distance = 2;
  options.uncertainty = 0.5;
  const auto judge = [&](double lower, double upper) {
    outcome.lower = lower;
    outcome.upper = upper;
    return api::worst(api::criteria_of(outcome, options)).value();
  };
  CHECK(judge(1, 1.5) == api::Verdict::pass);
  CHECK(judge(1, 1.6) == api::Verdict::undecided);
  CHECK(judge(2.5, 3) == api::Verdict::undecided);
  CHECK(judge(2.6, 3) == api::Verdict::fail);
}

TEST_CASE("verdict: an uncertainty leaves the share between those of two distances") {
  api::ComparisonOptions options;
  options.max_share_beyond = {1, 0.5};
  options.uncertainty = 0.25;
  options.direction = Direction::a_to_b;
  const auto judge = [&](const AreaInterval& nearer, const AreaInterval& farther) {
    Outcome outcome;
    outcome.areas.emplace().a_to_b.emplace().beyond = {nearer, farther};
    return api::worst(api::criteria_of(outcome, options)).value();
  };
  CHECK(judge({0.3, 0.5}, {0, 0.5}) == api::Verdict::pass);
  CHECK(judge({0.51, 0.6}, {0.4, 0.5}) == api::Verdict::undecided);
  CHECK(judge({0.6, 0.7}, {0.51, 0.6}) == api::Verdict::fail);
}

TEST_CASE("verdict: each region is held to its limit, the rest to that of the gate") {
  api::ComparisonOptions options;
  options.max_distance = 2;
  options.uncertainty = 0.25;
  options.regions = {{Sphere{}, 1}, {Sphere{}, {}}};
  const auto judge = [&](double own, double other, double rest) {
    Outcome outcome;
    for (const double upper : {own, other, rest}) {
      RegionOutcome& region = outcome.regions.emplace_back();
      region.lower = region.upper = upper;
      outcome.lower = outcome.upper = std::max(outcome.upper, upper);
    }
    return api::worst(api::criteria_of(outcome, options)).value();
  };
  CHECK(judge(0.75, 1.75, 1.75) == api::Verdict::pass);
  CHECK(judge(1, 1.75, 1.75) == api::Verdict::undecided);
  CHECK(judge(1.5, 1.75, 1.75) == api::Verdict::fail);
  CHECK(judge(0.75, 2.5, 1.75) == api::Verdict::fail);
  CHECK(judge(0.75, 1.75, 2) == api::Verdict::undecided);
  CHECK(judge(1.5, 1.75, 2) == api::Verdict::fail);
}
