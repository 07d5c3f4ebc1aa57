#include "check/outcome.h"

#include <limits>
#include <string>

#include <doctest/doctest.h>

#include "api/formats/unread.h"
#include "api/result/examination.h"
#include "check/criteria.h"
#include "check/reports/wording.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

using Json = nlohmann::ordered_json;

// A criterion of a document, with the members of `found` in place of its own.
Json criterion(const Criterion& asked, const Json& found) {
  Json json = api::json_of(asked, "");
  if (found.is_object()) json.update(found);
  return json;
}

Gate with_limit(double max_distance) {
  Gate gate;
  set_limit(gate, max_distance);
  return gate;
}

// At most 0.5; `distance` is the interval of the document and of its criterion.
Result<Measured> measured(const std::string& distance) {
  Json document = Json::parse(R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":)" + distance + "}");
  document["criteria"] = {criterion(check::distance(0, 0, 0.5), document["distance"])};
  return measured_from(document, with_limit(0.5));
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

// `found`: the members of the share. At most 1 % beyond 0.1.
Result<Measured> with_area(const std::string& found, std::optional<double> max_distance = std::nullopt) {
  Json document = Json::parse(
      R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0.25,"upper":0.5},"criteria":[]})");
  Gate asked;
  asked.request.options.max_distance = max_distance;
  asked.request.options.max_share_beyond = api::ShareLimit{0.1, 0.01};
  if (max_distance) document["criteria"].push_back(api::json_of(distance(0.25, 0.5, *max_distance), ""));
  if (!found.empty()) {
    document["criteria"].push_back(criterion(share(0.1, 0.01, 0, 1, "timeout"), Json::parse(found)));
    document["share_beyond"]["share"] = Json::parse(found);
  }
  return measured_from(document, asked);
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
  const auto criteria = with_area(open, 0.5)->criteria;
  REQUIRE(criteria.size() == 2);
  CHECK(criteria[1].beyond == 0.1);
  CHECK(criteria[1].limit == 0.01);
  CHECK(criteria[1].upper == 0.03);
  CHECK(criteria[1].status == "timeout");
  CHECK(with_area(open, 0.5)->foremost().beyond == 0.1);
  CHECK(!with_area(open, 0.1)->foremost().beyond);
}

TEST_CASE("outcome: a share that a service may invent is refused") {
  for (const char* share :
       {"", R"({"lower":-0.5,"upper":0})", R"({"lower":0.5,"upper":0.25})", R"({"lower":0,"upper":1.5})",
        R"({"lower":"0","upper":1})", R"({"lower":null,"upper":1})"}) {
    CAPTURE(share);
    const auto refused = with_area(share);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("criterion 1 ") != std::string::npos);
  }
}

namespace {

// At most 1 inside and 2 outside; the sides with the members of `inside` and `outside`.
Result<Measured> in_zone(const std::string& refused, const std::string& inside, const std::string& outside) {
  Json document = Json::parse(R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0,"upper":3},)"
                              R"("gate":{"max_distance":null,"zone":[-1,2]},"sides":{"status":"complete","refused":)" +
                              refused + R"(,"inside":)" + inside + R"(,"outside":)" + outside + "}}");
  for (const auto& [side, limit] : {std::pair("inside", 1.0), std::pair("outside", 2.0)}) {
    Json found = document["sides"][side];
    if (const Json& why = document["sides"]["refused"]; !why.is_null()) found = {{"refused", why["detail"]}};
    if (found.is_object() && found.contains("point_a"))
      found["witness"] = {{"on", "a"},
                          {"point", found["point_a"]},
                          {"triangle", found["triangle_a"]},
                          {"nearest_point", nullptr},
                          {"nearest_triangle", nullptr}};
    const double unknown = std::numeric_limits<double>::infinity();
    Criterion asked = on_side(side, distance(0, unknown, limit, "complete"));
    document["criteria"].push_back(found.is_object() || found.is_null() ? criterion(asked, found) : found);
  }
  Gate asked;
  asked.request.options.zone = SideOptions::Limits{1, 2};
  return measured_from(document, asked);
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
  const auto& criteria = fail->criteria;
  REQUIRE(criteria.size() == 2);
  CHECK(criteria[0].side == "inside");
  CHECK(criteria[1].side == "outside");
  CHECK(fail->foremost().side == "inside");
  CHECK(fail->limit->side == "inside");
  CHECK(fail->limit->limit == 1);
  CHECK(in_zone("null", side(0, 1), side(1, 2))->limit->limit == 2);
  CHECK(in_zone("null", side(1.5, 2), side(2.5, 3))->limit->limit == 1);
  CHECK(in_zone("null", side(0, 1), side(1, 3))->limit->side == "outside");
  GateOutcome outcome;
  outcome.gate.request.options.zone = SideOptions::Limits{1, 2};
  outcome.measured = *fail;
  CHECK(outcome.advice() ==
        "Look at (1, 2, 3) on triangle 7 of the candidate: it is 1.5 or more inside of the baseline.");
  CHECK(limit_of(outcome) == "1 inside");
  CHECK(interval_of(outcome) == "1.5 .. 2 inside");
  CHECK(
      finding_of(outcome) ==
      "the distance inside is at least 1.5, above the limit of 1 inside; the distance outside is at most 2, within the "
      "limit of 2 outside");
}

TEST_CASE("outcome: nothing is known of a zone whose baseline has no sides, which no rule excuses") {
  const auto open = in_zone(R"({"detail":"mesh b is open","reason":"open","at":null})", "null", "null");
  CHECK(open->verdict == Verdict::undecided);
  CHECK(open->limit->limit == 2);
  GateOutcome outcome;
  outcome.gate.request.options.zone = SideOptions::Limits{1, 2};
  outcome.gate.warn_only = true;
  outcome.measured = *open;
  CHECK(outcome.level(Undecided::warn) == Level::failure);
  CHECK(finding_of(outcome) == "nothing is inside or outside: the baseline is open");
  CHECK(!in_zone("null", "1", side(1, 2)).ok());
  CHECK(!in_zone("null", side(2, 1), side(1, 2)).ok());
}

TEST_CASE("outcome: a document with other criteria than were asked for is refused") {
  Json document = Json::parse(
      R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0.1,"upper":0.2},"criteria":[]})");
  const auto refused = [&](const std::optional<Criterion>& found) {
    document["criteria"] = Json::array();
    if (found) document["criteria"].push_back(api::json_of(*found, ""));
    return !measured_from(document, with_limit(0.5)).ok();
  };
  CHECK(!refused(distance(0.1, 0.2, 0.5)));
  CHECK(refused({}));
  CHECK(refused(distance(0.1, 0.2, 0.6)));
  CHECK(refused(share(0.5, 0.5, 0.1, 0.2)));
  CHECK(refused(on_side("inside", distance(0.1, 0.2, 0.5))));
  CHECK(refused(in_region("bore", distance(0.1, 0.2, 0.5))));
  CHECK(refused(distance(0.1, 0.15, 0.5)));  // contradicts `distance`
  document["criteria"] = {api::json_of(distance(0.1, 0.2, 0.5), ""), api::json_of(distance(0.1, 0.2, 0.6), "")};
  CHECK(measured_from(document, with_limit(0.5)).error().message.find("criterion 2 was not asked for") !=
        std::string::npos);
  document["criteria"][1] = api::json_of(api::expectation("watertight", api::Verdict::pass, "yes", "yes"), "");
  CHECK(measured_from(document, with_limit(0.5)).ok());
  document["criteria"][0]["refused"] = "mesh b is open";
  CHECK(!measured_from(document, with_limit(0.5)).ok());
  document.erase("criteria");
  CHECK(measured_from(document, with_limit(0.5)).error().message.find("update the service") != std::string::npos);
}

TEST_CASE("outcome: the region that fails is the foremost, and its point is the witness") {
  Json document = Json::parse(
      R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0.1,"upper":0.2},"regions":[
      {"name":"bore","status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0.1,"upper":0.2}},
      {"name":"rest","status":"converged","a_to_b":null,"b_to_a":null,"distance":{"lower":0,"upper":1e-8}}]})");
  Criterion bore = in_region("bore", distance(0.1, 0.2, 0.05));
  bore.at = Criterion::Place{false, {1, 2, 3}, 7, Vec3(1, 2, 4), 9};
  document["criteria"] = {api::json_of(in_region("rest", distance(0, 1e-8, 0.5)), ""), api::json_of(bore, "")};
  Region region;
  region.name = "bore";
  region.max_distance = 0.05;
  Gate asked = with_limit(0.5);
  asked.request.options.regions = {region};
  const auto found = measured_from(document, asked);
  REQUIRE(found.ok());
  CHECK(found->verdict == Verdict::fail);
  CHECK(found->lower == 0);
  CHECK(found->foremost().name == "distance in bore");
  CHECK(found->reached == 0.1);
  REQUIRE(found->witness);
  CHECK_FALSE(found->witness->on_candidate);
  CHECK(found->witness->to_triangle == 9);
  GateOutcome outcome;
  outcome.measured = *found;
  CHECK(interval_of(outcome) == "bore: 0.1 .. 0.2");
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
