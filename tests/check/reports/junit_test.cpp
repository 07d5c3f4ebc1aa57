#include "check/reports/reports.h"

#include <cmath>
#include <string>

#include <doctest/doctest.h>
#include <pugixml.hpp>

#include "check/criteria.h"
#include "check/reports/sample_reports.h"
#include "check/reports/wording.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

pugi::xml_document parsed(const Report& report) {
  pugi::xml_document document;
  const std::string text = to_junit(report, {});
  REQUIRE(document.load_buffer(text.data(), text.size()));
  return document;
}

std::string property(pugi::xml_node suite, const char* name) {
  return suite.child("properties").find_child_by_attribute("property", "name", name).attribute("value").value();
}

}  // namespace

TEST_CASE("junit: failures and errors count, warnings pass") {
  const pugi::xml_document document = parsed(samples::ordinary());
  const auto suite = [&](const char* name) {
    return document.child("testsuites").find_child_by_attribute("testsuite", "name", name);
  };
  CHECK_FALSE(suite("bracket").child("testcase").first_child());
  CHECK(suite("lid").child("testcase").child("failure").attribute("type").value() == std::string("fail"));
  CHECK(suite("hinge").child("testcase").child("failure").attribute("type").value() == std::string("undecided"));
  CHECK(std::string(suite("screw").child("testcase").child("error").attribute("message").value())
            .rfind("'screw' has no facet", 0) == 0);
  CHECK_FALSE(suite("lod-2").child("testcase").first_child());
  CHECK(std::string(suite("lod-2").child_value("system-out")).rfind("warning: the distance is at least", 0) == 0);
  CHECK(suite("lid").attribute("failures").as_int() == 1);
  CHECK(suite("lid").attribute("errors").as_int() == 0);
  CHECK(suite("screw").attribute("errors").as_int() == 1);
  CHECK(suite("lod-2").attribute("failures").as_int() == 0);
}

TEST_CASE("junit: properties hold every digit") {
  const pugi::xml_document document = parsed(samples::report_of({samples::failed("lid")}));
  const pugi::xml_node suite = document.child("testsuites").child("testsuite");
  CHECK(property(suite, "lower") == "0.0968");
  CHECK(property(suite, "upper") == "0.0977");
  CHECK(property(suite, "limit") == "0.05");
  CHECK(property(suite, "units") == "mm");
  CHECK(property(suite, "witness.from") == "1.5 -2 0.30000000000000004");
  CHECK(property(suite, "witness.from_triangle") == "17");
  CHECK(property(suite, "source") == "parts/gates.yaml:7");
  CHECK(suite.attribute("time").value() == std::string("1.235"));
  CHECK(suite.attribute("timestamp").value() == std::string("1970-01-01T00:00:00"));
  CHECK(suite.child("testcase").attribute("classname").value() == std::string("meshgauge.gates"));
}

TEST_CASE("junit: an allowed undecided gate passes, an interrupted one fails") {
  Report report = samples::report_of({samples::undecided("hinge")});
  CHECK(parsed(report).select_node("//failure"));
  report.undecided = Undecided::warn;
  CHECK_FALSE(parsed(report).select_node("//failure"));
  report.outcomes[0].measured.reset();
  report.outcomes[0].interrupted = true;
  report.undecided = Undecided::separate;
  CHECK(parsed(report).select_node("//failure").node().attribute("message").value() == report.outcomes[0].advice());
}

TEST_CASE("junit: names are read back as they are shown, whatever they hold") {
  const pugi::xml_document document = parsed(samples::hostile());
  auto test = document.child("testsuites").child("testsuite");
  for (const std::string& name : samples::hostile_names()) {
    for (int verdicts = 0; verdicts < 4; ++verdicts, test = test.next_sibling("testsuite")) {
      CHECK(test.attribute("name").value() == shown_name(name));
      CHECK(test.child("testcase").attribute("name").value() == shown_name(name));
      if (verdicts < 3) CHECK(property(test, "note") == shown_name(name));
    }
  }
  CHECK_FALSE(test);
}

TEST_CASE("junit: no character that XML 1.0 forbids, not even as a reference") {
  const std::string text = to_junit(samples::hostile(), {});
  for (const char c : text) {
    const bool allowed = static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t';
    REQUIRE(allowed);
  }
  // Line ends and tabs are allowed, and the only ones that are made.
  for (std::size_t at = text.find("&#"); at != std::string::npos; at = text.find("&#", at + 1)) {
    const std::string reference = text.substr(at, 5);
    REQUIRE_MESSAGE((reference == "&#10;" || reference == "&#09;"), reference);
  }
}

TEST_CASE("junit: the link to a gate's page") {
  GateOutcome seen = samples::failed("lid");
  CHECK(property(parsed(samples::report_of({seen})).child("testsuites").child("testsuite"), "link").empty());
  seen.measured->link = "https://ci.example/c/1";
  const pugi::xml_document document = parsed(samples::report_of({seen}));
  const pugi::xml_node suite = document.child("testsuites").child("testsuite");
  CHECK(property(suite, "link") == "https://ci.example/c/1");
  CHECK(std::string(suite.child_value("system-out")).find("to be seen at: https://ci.example/c/1\n") !=
        std::string::npos);
}

TEST_CASE("junit: a limit of the area") {
  const pugi::xml_document document = parsed(samples::report_of({samples::area("lid")}));
  const auto suite = document.child("testsuites").child("testsuite");
  CHECK(property(suite, "share_beyond.upper") == "0.00269876");
  CHECK(property(suite, "share_beyond.limit") == "0.01");
  CHECK(property(suite, "limit").empty());
}

TEST_CASE("junit: a zone, and a baseline without sides") {
  const GateOutcome zone = samples::zone("lid");
  GateOutcome open = zone;
  change(*open.measured, [](Criterion& c) {
    c.lower = 0;
    c.upper = INFINITY;
    c.refused = "the baseline is open";
  });
  const auto suite_of = [](const pugi::xml_document& document) {
    return document.child("testsuites").child("testsuite");
  };
  const auto document = parsed(samples::report_of({zone})), refused = parsed(samples::report_of({open}));
  CHECK(property(suite_of(document), "inside.upper") == "0.07");
  CHECK(property(suite_of(document), "outside.limit") == "0.1");
  CHECK(property(suite_of(refused), "inside.limit") == "0.05");
  CHECK(property(suite_of(refused), "inside.lower").empty());
  CHECK(property(suite_of(refused), "sides.refused") == "the baseline is open");
  CHECK(to_junit(samples::report_of({open}), {}).find("inf") == std::string::npos);
}
