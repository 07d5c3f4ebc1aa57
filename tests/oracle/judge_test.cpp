// The judge accepts right outcomes and catches wrong ones, down to one unit in the last place.
#include "oracle/judge.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::oracle;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double next_up(double x) { return std::nextafter(x, kInf); }
double next_down(double x) { return std::nextafter(x, -kInf); }

// A small square at height 1 over a large one: h(A,B) = 1, h(B,A) = 3.
struct Case {
  Mesh a = shapes::moved(shapes::grid(1), {1, 1, 1});
  Mesh b = shapes::grid(1, 4);
  Options options;
  Outcome outcome;

  Case() {
    options.tolerance = {1e-9, std::nullopt, std::nullopt};
    outcome.a_to_b = Directed{{1, 1, Witness{{1, 1, 1}, 0, {1, 1, 0}, 0}}, {2, 1}, {}};
    outcome.b_to_a = Directed{{3, 3, Witness{{4, 4, 0}, 0, {2, 2, 1}, 0}}, {2, 1}, {}};
    outcome.lower = outcome.upper = 3;
    outcome.met_by = Rule::absolute;
    outcome.diagonal_a = std::sqrt(2.0);
  }

  // One direction alone.
  Case& only_a() {
    options.direction = Direction::a_to_b;
    outcome.b_to_a.reset();
    outcome.lower = outcome.upper = 1;
    return *this;
  }
  Bounds& bounds() { return outcome.a_to_b->bounds; }
  Witness& witness() { return *bounds().witness; }

  std::string verdict(const Circumstances& circumstances = {}, std::size_t max_splits = 0) {
    Judge judge(a, b, {200, max_splits});
    const auto violation = judge.judge(options, outcome, circumstances);
    return violation ? violation->check : "";
  }
};

}  // namespace

TEST_CASE("the judge accepts a right outcome") {
  CHECK(Case().verdict() == "");
  CHECK(Case().only_a().verdict() == "");
}

TEST_CASE("the judge catches an upper bound one unit too small") {
  Case c;
  c.only_a();
  c.bounds().lower = c.outcome.lower = 0.5;
  c.bounds().upper = c.outcome.upper = next_down(1);
  c.options.tolerance.absolute = 1;
  CHECK(c.verdict() == "upper");
}

TEST_CASE("the judge catches a lower bound one unit too large") {
  Case c;
  c.only_a();
  c.bounds().upper = c.outcome.upper = 1 + 1e-10;
  CHECK(c.verdict() == "");
  c.bounds().lower = c.outcome.lower = next_up(1);
  CHECK(c.verdict() == "lower");
}

TEST_CASE("the judge catches a lower bound that ignores the distance of the witness from its mesh") {
  Case c;
  c.only_a();
  c.witness().point_a.z() = next_up(1);
  CHECK(c.verdict() == "");  // distance and offset grow alike
  c.bounds().lower = c.outcome.lower = next_up(1);
  c.bounds().upper = c.outcome.upper = 1 + 1e-10;
  CHECK(c.verdict() == "lower");
  c.witness().point_a = {0.9, 1, 1};
  CHECK(c.verdict() == "lower");
}

TEST_CASE("the judge catches an irrational distance that is rounded the wrong way") {
  Case c;
  c.only_a();
  c.a = shapes::grid(1);
  c.b = shapes::moved(shapes::grid(1), {0.5, 0.5, 0});
  const double above = std::sqrt(0.5);  // rounded, and larger than the root
  c.outcome.a_to_b->bounds = {next_down(above), above, Witness{{0, 0, 0}, 0, {0.5, 0.5, 0}, 0}};
  c.outcome.lower = next_down(above), c.outcome.upper = above;
  CHECK(c.verdict() == "");
  c.bounds().lower = c.outcome.lower = above;
  CHECK(c.verdict() == "lower");
  c.bounds().lower = c.bounds().upper = c.outcome.lower = c.outcome.upper = next_down(above);
  CHECK(c.verdict() == "upper");
}

TEST_CASE("the exact bracket catches both wrong bounds without a witness or a sample") {
  Case c;
  c.only_a();
  CHECK(c.verdict({}, 10) == "");
  c.bounds().upper = c.outcome.upper = 1 + 1e-10;
  c.bounds().lower = c.outcome.lower = next_up(1);
  CHECK(c.verdict({}, 10) == "bracket");
}

TEST_CASE("the judge catches directions that are swapped, missing or badly combined") {
  Case c;
  std::swap(c.outcome.a_to_b, c.outcome.b_to_a);
  CHECK(c.verdict() != "");
  Case missing;
  missing.outcome.b_to_a.reset();
  CHECK(missing.verdict() == "combine");
  Case combined;
  combined.outcome.lower = 1;
  combined.options.tolerance.absolute = 3;
  CHECK(combined.verdict() == "combine");
}

TEST_CASE("the judge catches an invalid interval") {
  for (const auto& [lower, upper] :
       {std::pair(2.0, 1.0), std::pair(-1.0, 1.0), std::pair(0.0, kInf), std::pair(std::nan(""), 1.0)}) {
    Case c;
    c.only_a();
    c.bounds().lower = c.outcome.lower = lower;
    c.bounds().upper = c.outcome.upper = upper;
    CHECK((c.verdict() == "finite" || c.verdict() == "order"));
  }
}

TEST_CASE("the judge catches an invalid witness") {
  Case off;
  off.only_a().witness().point_a.x() += 0.5;  // on the square, but not on triangle 0's side of the diagonal
  off.witness().point_a.y() = 2;
  off.witness().point_b = {off.witness().point_a.x(), 2, 0};
  CHECK(off.verdict() != "");
  Case far;
  far.only_a().witness().point_b = {1, 2, 0};
  CHECK(far.verdict() == "witness");
  Case above;
  above.only_a().witness().point_b.z() = 1e-12;
  CHECK(above.verdict() == "witness");
  Case range;
  range.only_a().witness().triangle_b = 2;
  CHECK(range.verdict() == "witness");
  Case none;
  none.only_a().bounds().witness.reset();
  CHECK(none.verdict() == "lower");
}

TEST_CASE("the judge catches a rule or a stop reason that does not hold") {
  Case unmet;
  unmet.outcome.met_by.reset();
  CHECK(unmet.verdict() == "rule");
  Case other;
  other.outcome.met_by = Rule::relative;
  CHECK(other.verdict() == "rule");
  Case wide;
  wide.only_a();
  wide.bounds().upper = wide.outcome.upper = 1 + 2e-9;
  CHECK(wide.verdict() == "rule");
  for (const Stop stop : {Stop::timeout, Stop::cancelled, Stop::budget, Stop::gate_decided}) {
    Case c;
    c.outcome.stop = stop;
    CHECK(c.verdict() == "stop");
  }
  Case gate;
  gate.options.max_distance = 2;
  gate.outcome.met_by.reset();
  gate.options.tolerance = {};
  gate.outcome.stop = Stop::timeout;
  CHECK(gate.verdict({true, false, false}) == "stop");  // lower = 3 had decided it
  gate.outcome.stop = Stop::gate_decided;
  CHECK(gate.verdict() == "");
}

TEST_CASE("the judge catches a precision floor that does not explain the width") {
  Case c;
  c.only_a().outcome.stop = Stop::precision_floor;
  c.outcome.met_by.reset();
  c.options.tolerance.absolute = 0;
  c.bounds().upper = c.outcome.upper = 1 + 1e-12;
  c.outcome.precision_floor = 1e-13;
  CHECK(c.verdict() == "floor");
  c.outcome.precision_floor = 1e-11;
  CHECK(c.verdict() == "");
  c.options.tolerance.relative = 2e-12;  // it holds: converged would have been right
  CHECK(c.verdict() == "rule");
}

TEST_CASE("the judge catches a wrong diagonal and a wrong count") {
  Case c;
  c.outcome.diagonal_a = 1.41421356;
  CHECK(c.verdict() == "diagonal");
  Case count;
  count.outcome.a_to_b->culling.survivors = 3;
  CHECK(count.verdict() == "culling");
}
