#include "check/outcome.h"

#include <limits>
#include <string>

#include <doctest/doctest.h>

#include "api/formats/unread.h"
#include "check/reports/wording.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Result<Measured> measured(const std::string& distance) {
  const std::string text = R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":)" + distance + "}";
  return measured_from(nlohmann::ordered_json::parse(text), {0.5, {}});
}

}  // namespace

TEST_CASE("outcome: the verdict is that of the interval") {
  CHECK(measured(R"({"lower":0,"upper":0})")->verdict == Verdict::pass);
  CHECK(measured(R"({"lower":0.25,"upper":0.5})")->verdict == Verdict::pass);
  CHECK(measured(R"({"lower":0.5,"upper":0.75})")->verdict == Verdict::undecided);
  CHECK(measured(R"({"lower":0.75,"upper":0.75})")->verdict == Verdict::fail);
  const auto open = measured(R"({"lower":0,"upper":null})");
  REQUIRE(open.ok());
  CHECK(open->upper == std::numeric_limits<double>::infinity());
  CHECK(open->verdict == Verdict::undecided);
}

TEST_CASE("outcome: a document without a valid interval is an Error") {
  for (const char* distance : {R"({"lower":0,"upper":-1})", R"({"lower":-1,"upper":-0.5})", R"({"lower":-1,"upper":0})",
                               R"({"lower":0.25,"upper":0.125})", R"({"lower":-1e-300,"upper":null})",
                               R"({"lower":null,"upper":1})", R"({"lower":"0","upper":1})", R"({"upper":1})", "null"}) {
    CAPTURE(distance);
    const auto refused = measured(distance);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::internal);
    CHECK(refused.error().message.find("is not that of a comparison") != std::string::npos);
  }
}

namespace {

// `share`: the member share_beyond's, or empty. At most 1 % beyond 0.1.
Result<Measured> with_area(const std::string& share, std::optional<double> max_distance = std::nullopt) {
  const std::string text = R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0.25,"upper":0.5},)"
                           R"("areas":{"a_to_b":{"status":"complete"},"b_to_a":{"status":"timeout"}})" +
                           (share.empty() ? "" : R"(,"share_beyond":{"share":)" + share + "}") + "}";
  return measured_from(nlohmann::ordered_json::parse(text), {max_distance, api::ShareLimit{0.1, 0.01}});
}

}  // namespace

TEST_CASE("outcome: a limit of the area decides alone, or with the distance") {
  const char *pass = R"({"lower":0,"upper":0.01})", *fail = R"({"lower":0.02,"upper":0.03})";
  const char* open = R"({"lower":0.01,"upper":0.03})";
  CHECK(with_area(pass)->verdict == Verdict::pass);
  CHECK(with_area(fail)->verdict == Verdict::fail);
  CHECK(with_area(open)->verdict == Verdict::undecided);
  CHECK(with_area(pass, 0.5)->verdict == Verdict::pass);
  CHECK(with_area(pass, 0.1)->verdict == Verdict::fail);
  CHECK(with_area(fail, 0.5)->verdict == Verdict::fail);
  CHECK(with_area(open, 0.5)->verdict == Verdict::undecided);
  CHECK(with_area(open, 0.1)->verdict == Verdict::fail);
  CHECK(with_area(fail, 0.3)->verdict == Verdict::fail);
  const auto criteria = criteria_of(*with_area(open, 0.5));
  REQUIRE(criteria.size() == 2);
  CHECK(criteria[1].beyond == 0.1);
  CHECK(criteria[1].limit == 1);
  CHECK(criteria[1].upper == doctest::Approx(3));
  CHECK(criteria[1].status == "timeout");
  CHECK(foremost(*with_area(open, 0.5)).beyond == 0.1);
  CHECK(!foremost(*with_area(open, 0.1)).beyond);
}

TEST_CASE("outcome: a share that a service may invent is refused") {
  for (const char* share :
       {"", "null", R"({"lower":0})", R"({"lower":-0.5,"upper":0})", R"({"lower":0.5,"upper":0.25})",
        R"({"lower":0,"upper":1.5})", R"({"lower":"0","upper":1})", R"({"lower":null,"upper":1})"}) {
    CAPTURE(share);
    const auto refused = with_area(share);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("share of the area") != std::string::npos);
  }
}

namespace {

Result<Measured> in_zone(const std::string& refused, const std::string& inside, const std::string& outside) {
  const std::string text = R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0,"upper":3},)"
                           R"("gate":{"max_distance":null,"zone":[-1,2]},)"
                           R"("sides":{"status":"complete","refused":)" +
                           refused + R"(,"inside":)" + inside + R"(,"outside":)" + outside + "}}";
  return measured_from(nlohmann::ordered_json::parse(text), {{}, {}, SideOptions::Zone{1, 2}});
}

std::string side(double lower, double upper) {
  return R"({"lower":)" + std::to_string(lower) + R"(,"upper":)" + std::to_string(upper) +
         R"(,"point_a":[1,2,3],"triangle_a":7})";
}

}  // namespace

TEST_CASE("outcome: a zone has a criterion for each side") {
  CHECK(in_zone("null", side(0, 1), side(1, 2))->verdict == Verdict::pass);
  CHECK(in_zone("null", side(0, 1.5), side(1, 2))->verdict == Verdict::undecided);
  const auto fail = in_zone("null", side(1.5, 2), side(1, 2));
  CHECK(fail->verdict == Verdict::fail);
  const auto criteria = criteria_of(*fail);
  REQUIRE(criteria.size() == 2);
  CHECK(criteria[0].side == "inside");
  CHECK(criteria[1].side == "outside");
  CHECK(foremost(*fail).side == "inside");
  CHECK(fail->shown.side == "inside");
  CHECK(fail->shown.limit == 1);
  CHECK(in_zone("null", side(0, 1), side(1, 2))->shown.limit == 2);
  CHECK(in_zone("null", side(1.5, 2), side(2.5, 3))->shown.limit == 1);
  CHECK(in_zone("null", side(0, 1), side(1, 3))->shown.side == "outside");
  GateOutcome outcome;
  outcome.gate.zone = ZoneLimit{{1, {}, {}}, {2, {}, {}}};
  outcome.measured = *fail;
  CHECK(outcome.advice() ==
        "Look at (1, 2, 3) on triangle 7 of the candidate: it is 1.5 or more inside of the baseline.");
  CHECK(limit_of(outcome) == "1 inside, 2 outside");
  CHECK(interval_of(outcome) == "1.5 .. 2 inside, 1 .. 2 outside");
  CHECK(
      finding_of(outcome) ==
      "the distance inside is at least 1.5, above the limit of 1 inside; the distance outside is at most 2, within the "
      "limit of 2 outside");
}

TEST_CASE("outcome: nothing is known of a zone whose baseline has no sides, which no rule excuses") {
  const auto open = in_zone(R"({"detail":"mesh b is open","reason":"open","at":null})", "null", "null");
  CHECK(open->verdict == Verdict::undecided);
  CHECK(open->shown.limit == 2);
  GateOutcome outcome;
  outcome.gate.zone = ZoneLimit{{1, {}, {}}, {2, {}, {}}};
  outcome.gate.warn_only = true;
  outcome.measured = *open;
  CHECK(outcome.level(Undecided::warn) == Level::failure);
  CHECK(finding_of(outcome) == "nothing is inside or outside of the baseline: the baseline is open");
  CHECK(!in_zone("null", "1", side(1, 2)).ok());
  CHECK(!in_zone("null", side(2, 1), side(1, 2)).ok());
}

TEST_CASE("outcome: what was not read of a mesh is a note of the gate, its other notes are not") {
  api::Unread surfaces;
  surfaces.add("free-form surfaces (surf)", 2);
  const std::string unread = surfaces.remarks().at(0);
  const auto found = measured(R"({"lower":0,"upper":0},"meshes":{"a":{"notes":["vertices merged: 3",")" + unread +
                              R"("]},"b":{"notes":[")" + unread + "\"]}}");
  REQUIRE(found.ok());
  CHECK(found->unread == std::vector<std::string>{"the candidate: " + unread, "the baseline: " + unread});
  GateOutcome outcome;
  outcome.measured = *found;
  outcome.gate.notes = {"'*.stl' passes over '.x.stl'"};
  CHECK(notes_of(outcome).size() == 3);
  CHECK(notes_of(outcome) == unmeasured_of(outcome));
  CHECK(measured(R"({"lower":0,"upper":0},"meshes":{"a":{"notes":[1]}})")->unread.empty());
}
