#include "check/outcome.h"

#include <limits>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

Result<Measured> measured(const std::string& distance) {
  const std::string text = R"({"status":"converged","a_to_b":null,"b_to_a":null,"distance":)" + distance + "}";
  return measured_from(nlohmann::ordered_json::parse(text), 0.5);
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
