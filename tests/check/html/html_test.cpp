#include "check/html/html.h"

#include <limits>
#include <regex>
#include <set>

#include <doctest/doctest.h>

#include "api/result/examination.h"
#include "check/criteria.h"
#include "check/html/diagrams.h"
#include "check/html/html_gate.h"
#include "check/html/markup.h"
#include "check/reports/sample_reports.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

std::set<std::string> all_of(const std::string& text, const char* pattern) {
  std::set<std::string> found;
  const std::regex regex(pattern);
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) found.insert((*it)[1]);
  return found;
}

std::string between(const std::string& text, const std::string& before, const std::string& after) {
  const auto begin = text.find(before);
  REQUIRE(begin != std::string::npos);
  const auto from = begin + before.size();
  return text.substr(from, text.find(after, from) - from);
}

GatePicture missing(const std::string& why) { return {{}, why}; }

}  // namespace

TEST_CASE("nothing from outside becomes an element or an attribute, whatever the names are") {
  const Report report = samples::hostile();
  std::vector<GatePicture> pictures;
  for (const GateOutcome& outcome : report.outcomes) pictures.push_back(missing(outcome.gate.name));
  const std::string page = to_html(report, pictures);
  const std::set<std::string> known =
      all_of(to_html(samples::ordinary(), std::vector(9, missing("gone"))), "<([A-Za-z!?][A-Za-z0-9]*)");
  for (const std::string& tag : all_of(page, "<([A-Za-z!?][A-Za-z0-9]*)")) {
    CAPTURE(tag);
    CHECK(known.count(tag) == 1);
  }
  CHECK(all_of(page, "\\s(on[a-z]+)=\"").empty());
  for (const char* never : {"<script", "<link", "<iframe", "<base", "<form", "javascript:\"", " style=\""}) {
    CAPTURE(never);
    CHECK(page.find(never) == std::string::npos);
  }
  for (const GateOutcome& outcome : report.outcomes) {
    CHECK(page.find(escaped(outcome.gate.name)) != std::string::npos);
  }
}

TEST_CASE("the policy allows the page's own style, pictures inside of it, and nothing else") {
  const std::string page = to_html(samples::ordinary(), {});
  const std::string style = between(page, "<style>", "</style>");
  const std::string policy = between(page, "Content-Security-Policy\" content=\"", "\"");
  CHECK(policy == "default-src 'none'; style-src 'sha256-" + sha256_base64(style) +
                      "'; img-src data:; base-uri 'none'; form-action 'none'");
  CHECK(page.find("://") == std::string::npos);
  CHECK(style.find("url(#hatch)") != std::string::npos);
  CHECK(style.find("@import") == std::string::npos);
}

TEST_CASE("failures come first, and the table links to every gate") {
  const Report report = samples::ordinary();
  const std::string page = to_html(report, {});
  std::size_t last_failure = 0, first_other = std::string::npos;
  for (std::size_t i = 0; i < report.outcomes.size(); ++i) {
    CHECK(page.find("href=\"#" + gate_id(i) + "\"") != std::string::npos);
    const auto at = page.find("id=\"" + gate_id(i) + "\"");
    REQUIRE(at != std::string::npos);
    if (report.outcomes[i].level(report.undecided) == Level::failure)
      last_failure = std::max(last_failure, at);
    else
      first_other = std::min(first_other, at);
  }
  CHECK(last_failure < first_other);
}

TEST_CASE("the headline describes the run") {
  const auto headline = [](const Report& report) {
    return between(between(to_html(report, {}), "<h1>", "</h1>"), "</svg>", "<");
  };
  CHECK(headline(samples::report_of({})) == "No gate was checked");
  CHECK(headline(samples::report_of({samples::passed("a")})) == "The gate passes");
  CHECK(headline(samples::report_of({samples::passed("a"), samples::passed("b")})) == "All 2 gates pass");
  CHECK(headline(samples::report_of({samples::failed("a")})) == "The gate fails");
  CHECK(headline(samples::report_of({samples::failed("a"), samples::passed("b"), samples::broken("c")})) ==
        "1 of 3 gates fails, 1 could not be measured");
  const Report mixed = samples::report_of({samples::failed("a"), samples::broken("b"), samples::undecided("c")});
  CHECK(between(to_html(mixed, {}), "<title>", "</title>") == "1 of 3 gates fails \xC2\xB7 meshgauge");
  Report warned = samples::report_of({samples::failed("a")});
  warned.outcomes[0].gate.warn_only = true;
  CHECK(to_html(warned, {}).find("only warns") != std::string::npos);
}

TEST_CASE("a gate without a mesh is a card with its message, one without a picture says why") {
  const Report report = samples::report_of({samples::broken("broken"), samples::failed("failed")});
  const std::string page = to_html(report, std::vector{missing("nothing"), missing("'<x>' is gone")});
  CHECK(page.find(escaped(report.outcomes[0].error->message)) != std::string::npos);
  CHECK(page.find("No picture: &#39;&lt;x&gt;&#39; is gone.") != std::string::npos);
}

TEST_CASE("a page without pictures is as small as the header says") {
  std::vector<GateOutcome> outcomes;
  for (int i = 0; i < 100; ++i) outcomes.push_back(samples::failed("gate " + std::to_string(i)));
  CHECK(to_html(samples::report_of(std::move(outcomes)), {}).size() < 40'000 + 100 * 12'000);
}

TEST_CASE("a page of very many gates says which have pictures, and is small where they have none") {
  std::vector<GateOutcome> outcomes;
  for (int i = 0; i < 1000; ++i) outcomes.push_back(samples::passed("gate " + std::to_string(i)));
  GatePicture left_out;
  left_out.left_out = true;
  std::vector<GatePicture> pictures(1000, left_out);
  for (std::size_t i = 0; i < 10; ++i) pictures[i] = missing("gone");
  for (std::size_t i = 0; i < 7; ++i) pictures[i] = GatePicture{{Surface{}}, "", false};
  pictures[9] = GatePicture{};  // of a gate that could not be measured
  const std::string page = to_html(samples::report_of(std::move(outcomes)), pictures);
  CHECK(page.find("Tables and witnesses of 9 gates, pictures of 7: ") != std::string::npos);
  CHECK(page.find("Of 990 others, the interval") != std::string::npos);
  CHECK(all_of(page, "(<details>)").size() == 1);
  CHECK(page.size() < 40'000 + 10 * 12'000 + 1000 * 6'000);
  MESSAGE("bytes a gate: ", page.size() / 1000);
  const std::string few = to_html(samples::ordinary(), std::vector(9, missing("gone")));
  CHECK(few.find("Tables and witnesses") == std::string::npos);
}

TEST_CASE("statistics that were interrupted say so") {
  const auto page_of = [](const char* status) {
    GateOutcome outcome = samples::passed("gate");
    const nlohmann::ordered_json mean{{"value", 1.0}, {"standard_error", 0.1}};
    outcome.measured->document["statistics"] = {{"status", status}, {"a_to_b", {{"mean", mean}}}, {"b_to_a", nullptr}};
    return to_html(samples::report_of({outcome}), {});
  };
  CHECK(page_of("complete").find("Not all statistics") == std::string::npos);
  CHECK(page_of("cancelled").find("asked for are there: the run was interrupted.") != std::string::npos);
  CHECK(page_of("timeout").find("asked for are there: the time was over.") != std::string::npos);
  CHECK(page_of("<b>").find("asked for are there: &lt;b&gt;.") != std::string::npos);
}

TEST_CASE("the drawing of an interval puts the limit between pass and fail, and the bar where the interval is") {
  const auto x_of = [](const std::string& drawing, const std::string& css_class) {
    return std::stod(between(drawing, "class=\"" + css_class + "\" x=\"", "%"));
  };
  const std::string fail = interval_drawing(distance(2, 3, 1), "mm");
  CHECK(x_of(fail, "ground fail") == doctest::Approx(100 / 3.75).epsilon(0.01));
  CHECK(x_of(fail, "bar fail") == doctest::Approx(200 / 3.75).epsilon(0.01));
  CHECK(fail.find("limit 1 mm") != std::string::npos);
  const std::string pass = interval_drawing(distance(0.5, 0.75, 1), "");
  CHECK(x_of(pass, "bar pass") < x_of(pass, "ground fail"));
  const std::string open = interval_drawing(distance(0, std::numeric_limits<double>::infinity(), 1), "");
  CHECK(x_of(open, "bar undecided") == 0);
  CHECK(between(open, "bar undecided\" x=\"0.00%\" width=\"", "\"") == "100.00%");
  CHECK(open.find("nan") == std::string::npos);
}

TEST_CASE("a limit of the area is drawn and worded in percent, alone and beside one of the distance") {
  GateOutcome area = samples::area("lid");
  const std::string alone = to_html(samples::report_of({area}), {});
  CHECK(alone.find("limit 1 %") != std::string::npos);
  CHECK(alone.find("The share of the area farther than 0.05 mm is between 0.2012 and 0.2699 %") != std::string::npos);
  CHECK(alone.find(
            "Certainly within the limit of 1 %: between 0.2012 and 0.2699 % of the area is farther than 0.05 mm, at "
            "most 27 % of the limit.") != std::string::npos);
  CHECK(alone.find("The distance is between") == std::string::npos);
  area.gate.request.options.max_distance = 0.1;
  set_criteria(*area.measured, {distance(0.06, 0.07, 0.1), area.measured->criteria.front()});
  const std::string both = to_html(samples::report_of({area}), {});
  CHECK(both.find("<td class=\"number limit\">0.1 mm</td>") != std::string::npos);
  CHECK(both.find("<td class=\"number limit\">1 % beyond 0.05 mm</td>") != std::string::npos);
  CHECK(both.find("The distance is between 0.06 and 0.07") != std::string::npos);
  CHECK(both.find("the distance is at most 0.07 mm") != std::string::npos);
}

TEST_CASE("a zone is named by its sides, and pictures are judged by the side that fails") {
  const GateOutcome outcome = samples::zone("lid");
  GatePicture picture;
  picture.surfaces.emplace_back();
  picture.surfaces[0].histogram = {{}, {1}, 100, 0.25, 0.01, 0.06, 0.07};
  const std::string page = to_html(samples::report_of({outcome}), std::vector{picture});
  CHECK(page.find("25 % farther than the limit inside, 0.05 mm, on either side.") != std::string::npos);
  picture.surfaces[0].candidate = false;
  const std::string baseline = to_html(samples::report_of({outcome}), std::vector{picture});
  CHECK(baseline.find("on either side") == std::string::npos);
  CHECK(baseline.find("95 % within 0.06 mm. Estimated") != std::string::npos);
  CHECK(page.find("0.06 .. 0.07 mm inside</td>") != std::string::npos);
  CHECK(page.find("at least 19 % above the limit") != std::string::npos);
}

TEST_CASE("an expectation that is not met has a row, and so has the distance that passes beside it") {
  GateOutcome outcome = samples::passed("lid");
  CHECK(to_html(samples::report_of({outcome}), {}).find("gate criterion") == std::string::npos);
  outcome.expectations = {api::expectation("watertight", api::Verdict::fail, "no: 4 open edges", "yes"),
                          api::expectation("triangles", api::Verdict::pass, "12", "at most 20")};
  const std::string page = to_html(samples::report_of({outcome}), {});
  CHECK(page.find("<tr class=\"gate criterion fail\"><td><span class=\"badge pass\">") != std::string::npos);
  CHECK(page.find("watertight</th><td class=\"number words\">no: 4 open edges</td><td class=\"number limit "
                  "expected words\">expected yes<") != std::string::npos);
  CHECK(between(page, "<nav", "</nav>").find("triangles</th>") == std::string::npos);
}

TEST_CASE("units are escaped in drawings") {
  Criterion one = distance(2, 3, 1);
  CHECK(interval_drawing(one, "<mm\">").find("<mm") == std::string::npos);
  one.beyond = 0.5;
  CHECK(interval_drawing(one, "<mm\">").find("<mm") == std::string::npos);
  CHECK(colour_bar({1, true}, "<mm\">").find("<mm") == std::string::npos);
}

TEST_CASE("the service's page of a gate is a link, safely quoted") {
  GateOutcome seen = samples::failed("lid");
  CHECK(to_html(samples::report_of({seen}), {}).find("href=\"http") == std::string::npos);
  seen.measured->link = "https://ci.example/c/1\"><script>";
  const std::string page = to_html(samples::report_of({seen}), {});
  CHECK(between(page, "<p class=\"link\"><a href=\"", "\"") == "https://ci.example/c/1&quot;&gt;&lt;script&gt;");
  CHECK(page.find("<script") == std::string::npos);
  CHECK(page.find("as long as it keeps the result") != std::string::npos);
}
