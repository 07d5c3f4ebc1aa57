#include "check/reports/reports.h"

#include <algorithm>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#include "check/criteria.h"
#include "check/reports/sample_reports.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

std::size_t position(const std::string& text, const std::string& what) {
  const std::size_t at = text.find(what);
  REQUIRE_MESSAGE(at != std::string::npos, what);
  return at;
}

std::string bar_of(const GateOutcome& outcome) {
  const std::string text = to_markdown(samples::report_of({outcome}));
  const std::size_t row = position(text, "| `x` |");
  const std::size_t begin = text.rfind(" | `", text.find('\n', row)) + 4;
  return text.substr(begin, text.find('`', begin) - begin);
}

GateOutcome outcome_of(double lower, double upper, double limit) {
  GateOutcome outcome = samples::failed("x");
  set_criteria(*outcome.measured, {distance(lower, upper, limit)});
  return outcome;
}

}  // namespace

TEST_CASE("markdown: the verdict, then what did not pass, the worst first, then what passed") {
  const std::string text = to_markdown(samples::ordinary());
  CHECK(text.rfind("## ❌ meshgauge: not everything could be measured\n\n"
                   "5 gates: 1 passed, 2 failed, 1 undecided, 1 error. 1 of them only warn.\n",
                   0) == 0);
  CHECK(position(text, "| ❌ error | `screw` |") < position(text, "| ❌ fail | `lid` | 0.0968 .. 0.0977 mm | 0.05 mm |"));
  CHECK(position(text, "| ❌ fail | `lid` |") < position(text, "| ❔ undecided | `hinge` |"));
  CHECK(position(text, "| ❔ undecided | `hinge` |") < position(text, "| ⚠️ fail | `lod-2` |"));
  CHECK(position(text, "| ⚠️ fail | `lod-2` |") < position(text, "### ❌ `screw`"));
  CHECK(position(text, "### ⚠️ `lod-2`") < position(text, "<details><summary>1 gate passed</summary>"));
  CHECK(position(text, "<details>") < position(text, "| ✅ pass | `bracket` |"));
  CHECK(text.find("### ✅") == std::string::npos);
  position(text, "- witness (1.5, &#45;2, 0.3) mm on triangle 17");
  position(text, "- gate `parts/gates.yaml:7`\n");
}

TEST_CASE("markdown: a candidate that was moved is named although its gate passes") {
  GateOutcome outcome = samples::passed("a");
  outcome.measured->notes = {"the candidate was moved before it was measured"};
  CHECK(to_markdown(samples::report_of({outcome})).find("was moved") == std::string::npos);
  outcome.measured->motion = RigidMotion();
  position(to_markdown(samples::report_of({outcome})), "\n\n- `a`: the candidate was moved before it was measured\n");
}

TEST_CASE("markdown: headlines") {
  CHECK(to_markdown(samples::report_of({samples::passed("a")})).rfind("## ✅ meshgauge: all gates hold\n", 0) == 0);
  CHECK(to_markdown(samples::report_of({samples::failed("a")})).rfind("## ❌ meshgauge: failed\n", 0) == 0);
  Report report = samples::report_of({samples::undecided("a")});
  CHECK(to_markdown(report).rfind("## ❔ meshgauge: undecided\n", 0) == 0);
  report.interrupted = true;
  CHECK(to_markdown(report).find("The run was interrupted.") != std::string::npos);
}

TEST_CASE("markdown: bars agree with the verdict however near the limit is") {
  CHECK(bar_of(outcome_of(0.5, 0.6, 1)) == "·········███·······│·····");
  CHECK(bar_of(outcome_of(2, 2.1, 1)) == "·········│·········██····");
  for (const double x : {0.0, 1e-12, 0.3, 0.7999999999, 0.8, 0.9, 1.0 - 1e-16, 1.0, 1.0 + 1e-15, 1.3, 1e9}) {
    for (const double width : {0.0, 1e-15, 0.1, 1.0, 1e12}) {
      const GateOutcome outcome = outcome_of(x, x + width, 1);
      const std::string bar = bar_of(outcome);
      CAPTURE(bar);
      const std::size_t limit = bar.find("│"), first = bar.find("█"), last = bar.rfind("█");
      REQUIRE(first != std::string::npos);
      CHECK((last < limit) == (outcome.verdict() == Verdict::pass));
      CHECK((first > limit) == (outcome.verdict() == Verdict::fail));
      CHECK(std::count(bar.begin(), bar.end(), '\x82') + std::count(bar.begin(), bar.end(), '\xb7') +
                std::count(bar.begin(), bar.end(), '\x88') ==
            25);
    }
  }
}

TEST_CASE("markdown: names cannot break a row of the table") {
  const std::string text = to_markdown(samples::hostile());
  std::istringstream lines(text);
  std::size_t rows = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| ✅", 0) != 0 && line.rfind("| ❌", 0) != 0 && line.rfind("| ❔", 0) != 0) continue;
    CHECK(std::count(line.begin(), line.end(), '|') == 6);
    ++rows;
  }
  CHECK(rows == 4 * samples::hostile_names().size());
}

TEST_CASE("markdown: the length is limited and the rest is counted") {
  std::vector<GateOutcome> many;
  for (int i = 0; i < 3000; ++i) {
    many.push_back(samples::failed("gate-" + std::to_string(i)));
    many.push_back(samples::passed("gate+" + std::to_string(i)));
  }
  const Report report = samples::report_of(many);
  const std::string all = to_markdown(report);
  CHECK(all.size() <= kMarkdownBytes);
  CHECK(all.size() > kMarkdownBytes / 2);
  std::size_t last = 0;
  for (const std::size_t bytes : {1000U, 2000U, 10'000U, 100'000U, 400'000U}) {
    const std::string text = to_markdown(report, bytes);
    CHECK(text.size() <= bytes);
    CHECK(text.size() > last);
    position(text, " more gates found no room here.");
    position(text, "6000 gates: 3000 passed, 3000 failed");
    last = text.size();
  }
  Report hostile = samples::hostile();
  for (std::size_t bytes = 1000; bytes < 100'000; bytes += 777) CHECK(to_markdown(hostile, bytes).size() <= bytes);
}

TEST_CASE("markdown: verdict and details link to a gate's page") {
  GateOutcome seen = samples::failed("lid"), passed = samples::passed("bracket");
  seen.measured->link = "https://ci.example/c/1";
  passed.measured->link = "http://[::1]:8080/c/2";
  const std::string text = to_markdown(samples::report_of({seen, passed, samples::failed("other")}));
  position(text, "| ❌ [fail](<https://ci.example/c/1>) | `lid` |");
  position(text, "- [See the difference](<https://ci.example/c/1>), as long as the service keeps the result\n");
  position(text, "| ✅ [pass](<http://[::1]:8080/c/2>) | `bracket` |");
  position(text, "| ❌ fail | `other` |");
}

TEST_CASE("markdown: links to pages of batches are limited") {
  Report report = samples::report_of({samples::failed("a")});
  CHECK(to_markdown(report).find("See them") == std::string::npos);
  report.batches = {"https://ci.example/b/1"};
  CHECK(to_markdown(report).find("results: [batch 1](<https://ci.example/b/1>)\n") != std::string::npos);
  for (const char* more : {"2", "3", "4", "5"}) report.batches.push_back(std::string("https://ci.example/b/") + more);
  const std::string text = to_markdown(report);
  CHECK(text.find("[batch 3](<https://ci.example/b/3>) and 2 more\n") != std::string::npos);
  CHECK(text.find("https://ci.example/b/4") == std::string::npos);
}

TEST_CASE("markdown: a comment folds the limits that are kept and says where pictures belong") {
  GateOutcome one = samples::zone("nut");
  const Report report = samples::report_of({one, samples::passed("bracket")});
  const std::string text = to_comment(report);
  const std::size_t fold = position(text, "<details><summary>1 gate and 1 limit of others passed</summary>");
  CHECK(position(text, "| `nut`: distance inside |") < fold);
  CHECK(fold < position(text, "| pass | `nut`: distance outside |"));
  CHECK(position(text, "### ❌ `nut`") < position(text, "\n<!-- picture: nut.png -->\n"));
  const std::string summary = to_markdown(report);
  CHECK(summary.find("<!--") == std::string::npos);
  CHECK(position(summary, "| `nut`: distance outside |") < position(summary, "<details>"));
  position(to_comment(samples::report_of({samples::zone("nut")})), "<details><summary>1 limit passed</summary>");
}

TEST_CASE("markdown: a comment has room for what GitHub's page takes") {
  std::vector<GateOutcome> many;
  for (int i = 0; i < 500; ++i) many.push_back(samples::failed("gate-" + std::to_string(i)));
  CHECK(to_comment(samples::report_of(many)).size() <= kCommentBytes);
  CHECK(to_comment(samples::hostile()).size() <= kCommentBytes);
}

TEST_CASE("markdown: no name of a gate ends the mark of its picture") {
  Report hostile = samples::hostile();
  hostile.outcomes.push_back(samples::failed("--> <img src=x> <!--"));
  const std::string text = to_comment(hostile, 10'000'000);
  std::size_t marks = 0;
  for (std::size_t at = text.find("\n<!--"); at != std::string::npos; at = text.find("\n<!--", at + 1)) {
    const std::string mark = text.substr(at + 1, text.find('\n', at + 1) - at - 1);
    CHECK(mark.starts_with("<!-- picture: "));
    CHECK(mark.find("-->") == mark.size() - 3);
    ++marks;
  }
  CHECK(marks == 2 * samples::hostile_names().size() + 1);
}
