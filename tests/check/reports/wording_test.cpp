#include "check/reports/wording.h"

#include <limits>
#include <string>

#include <doctest/doctest.h>

#include "check/criteria.h"
#include "check/reports/sample_reports.h"

using namespace meshgauge;
using namespace meshgauge::check;

TEST_CASE("wording: names are shown on one line, hidden characters as escapes") {
  CHECK(shown_name("bracket v2.stl") == "bracket v2.stl");
  CHECK(shown_name("Größe 部品 🔩") == "Größe 部品 🔩");
  CHECK(shown_name("a\nb\r\tc") == "a\\nb\\r\\tc");
  CHECK(shown_name("\x1b[31m") == "\\x1B[31m");
  CHECK(shown_name(std::string_view("a\0b", 3)) == "a\\x00b");
  CHECK(shown_name("\xff\xc0\xaf") == "\\xFF\\xC0\\xAF");
  CHECK(shown_name("\xed\xa0\x80") == "\\xED\\xA0\\x80");  // half of a pair of surrogates
  CHECK(shown_name("half \xe2\x82") == "half \\xE2\\x82");
  CHECK(shown_name("\xe2\x80\xaegnp.exe") == "\\u202Egnp.exe");
  CHECK(shown_name("\xef\xbf\xbf") == "\\uFFFF");
  CHECK(shown_name("\xf0\x9f\xbf\xbf") == "\\U0001FFFF");
  CHECK(shown_name("") == "(unnamed)");
  CHECK(shown_name("   ") == "(unnamed)");
  CHECK(shown_text("a\n\tb\r") == "a\n\tb\\r");
  CHECK(shown_text("").empty());
}

TEST_CASE("wording: what was found, in half a sentence") {
  CHECK(finding_of(samples::passed("a")) == "the distance is at most 0.0123 mm, within the limit of 0.05 mm");
  CHECK(finding_of(samples::failed("a")) == "the distance is at least 0.0968 mm, above the limit of 0.05 mm");
  CHECK(finding_of(samples::undecided("a")) ==
        "the distance is between 0.04 and 0.06 mm: whether that is within the limit of 0.05 mm is not known (timeout)");
  GateOutcome unbounded = samples::undecided("a");
  change(*unbounded.measured, [](Criterion& c) { c.upper = std::numeric_limits<double>::infinity(); });
  CHECK(finding_of(unbounded) ==
        "the distance is at least 0.04 mm: whether that is within the limit of 0.05 mm is not known (timeout)");
  CHECK(interval_of(samples::failed("a")) == "0.0968 .. 0.0977 mm");
  GateOutcome wide = samples::failed("a");
  change(*wide.measured, [](Criterion& c) { c.upper = 52.91; });
  CHECK(interval_of(wide) == "at least 0.0968 mm");
  CHECK(finding_of(samples::broken("a")) == samples::broken("a").advice());
  CHECK(finding_of(samples::broken("a")).rfind("'a' has no facet", 0) == 0);
  CHECK(advice_of(samples::broken("a")).empty());
  CHECK(limit_of(samples::broken("a")) == "0.05 mm");
  GateOutcome share = samples::failed("a");
  set_share_of_diagonal(share.gate, 0.005);
  CHECK(limit_of(share) == "0.05 (0.5 % of the baseline's diagonal)");
  share.measured.reset();
  CHECK(limit_of(share) == "0.5 % of the baseline's diagonal");
  CHECK(advice_of(samples::failed("a")).find("(1.5, -2, 0.3) mm on triangle 17") != std::string::npos);
  CHECK(witness_of(samples::failed("a")).empty());
  CHECK(witness_of(samples::undecided("a")) ==
        "(1.5, -2, 0.3) mm on triangle 17 of the candidate; nearest is (1.5, -2, 0) mm on triangle 4 of the baseline");
}

TEST_CASE("wording: a limit of the area, alone and beside one of the distance") {
  const std::string limits = "; at most 1 % may be";
  GateOutcome area = samples::area("a");
  CHECK(limit_of(area) == "1 % beyond 0.05 mm");
  CHECK(interval_of(area) == "0.2012 .. 0.2699 %");
  CHECK(finding_of(area) == "between 0.2012 and 0.2699 % of the area is farther than 0.05 mm" + limits);
  change(*area.measured, [](Criterion& c) { c.lower = 0; });
  CHECK(finding_of(area) == "at most 0.2699 % of the area is farther than 0.05 mm" + limits);
  change(*area.measured, [](Criterion& c) { c.upper = 0; });
  CHECK(finding_of(area) == "none of the area is farther than 0.05 mm" + limits);
  change(*area.measured, [](Criterion& c) { c.upper = 0.0123456; });
  CHECK(finding_of(area) ==
        "at most 1.235 % of the area is farther than 0.05 mm: whether at most 1 % are is not known (complete)");
  GateOutcome both = samples::area("b");
  both.gate.request.options.max_distance = 0.1;
  set_criteria(*both.measured, {distance(0.06, 0.07, 0.1), both.measured->criteria.front()});
  CHECK(limit_of(both) == "0.1 mm");  // nearer to its limit than the area
  CHECK(interval_of(both) == "0.06 .. 0.07 mm");
  CHECK(criteria_in_words(both)[1].limit == "1 % beyond 0.05 mm");
  CHECK(criteria_in_words(both)[1].interval == "0.2012 .. 0.2699 %");
  CHECK(finding_of(both).find("within the limit of 0.1 mm; between 0.2012 and 0.2699 %") != std::string::npos);
  both.measured.reset();
  CHECK(limit_of(both) == "0.1 mm, 1 % beyond 0.05 mm");
}

TEST_CASE("wording: an uncertainty stands behind the limit") {
  GateOutcome outcome = samples::passed("a");
  change(*outcome.measured, [](Criterion& c) { c.uncertainty = 0.01; });
  CHECK(limit_of(outcome) == "0.05 mm ± 0.01 mm");
  CHECK(finding_of(outcome) == "the distance is at most 0.0123 mm, within the limit of 0.05 mm ± 0.01 mm");
  change(*outcome.measured, [](Criterion& c) { c.upper = 0.045; });
  CHECK(finding_of(outcome).find("whether that is within the limit of 0.05 mm ± 0.01 mm is not known") !=
        std::string::npos);
  GateOutcome area = samples::area("a");
  change(*area.measured, [](Criterion& c) { c.uncertainty = 0.01; });
  CHECK(limit_of(area) == "1 % beyond 0.05 mm ± 0.01 mm");
  CHECK(finding_of(area).find("farther than 0.05 mm ± 0.01 mm; at most 1 % may be") != std::string::npos);
}
