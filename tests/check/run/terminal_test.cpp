#include "check/run/terminal.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>

#include "check/run/gates.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

GateOutcome outcome(const std::string& name, const Measured& measured, bool warn_only = false) {
  GateOutcome made;
  made.gate = gate("a.stl", "b.stl", measured.criteria.front().limit);
  made.gate.name = name;
  made.gate.request.options.units.limit = LengthUnit::millimeter;
  made.gate.warn_only = warn_only;
  made.measured = measured;
  made.wall_ms = 1250;
  return made;
}

Report mixed() {
  Report report;
  report.outcomes = {outcome("bracket", measured(0.01, 0.02, 0.05)), outcome("hüll", measured(0.71, 0.73, 0.5)),
                     outcome("lod", measured(0.71, 0.73, 0.5), true),
                     outcome("slow", measured(0.25, 0.75, 0.5, "timeout"))};
  GateOutcome missing;
  missing.gate = gate("none.stl", "b.stl", 1);
  missing.error = Error{ErrorCode::invalid_request, "'none.stl' cannot be read", "a", ""};
  report.outcomes.push_back(missing);
  return report;
}

// What a display writes.
struct Output {
  std::FILE* file = open_memstream(&text, &size);
  char* text = nullptr;
  std::size_t size = 0;

  ~Output() {
    std::fclose(file);
    std::free(text);
  }
  std::string all() {
    std::fflush(file);
    return {text, size};
  }
};

}  // namespace

TEST_CASE("the table: columns below each other, advice below its gate, counts at the end") {
  CHECK(to_table(mixed(), {}) ==
        "PASS            bracket   0.01 .. 0.02 mm  at most 0.05 mm  1.25 s\n"
        "FAIL            hüll      0.71 .. 0.73 mm  at most 0.5 mm   1.25 s\n"
        "FAIL (warning)  lod       0.71 .. 0.73 mm  at most 0.5 mm   1.25 s\n"
        "UNDECIDED       slow      0.25 .. 0.75 mm  at most 0.5 mm   1.25 s\n"
        "    Decided by a limit of at least 0.75 mm (pass) or below 0.25 mm (fail); or a longer timeout than 30 s.\n"
        "ERROR           none.stl  -                at most 1        0.00 s\n"
        "    'none.stl' cannot be read. Check its path, its permissions and the step that writes it.\n"
        "5 gates: 1 pass, 2 fail, 1 undecided, 1 error\n");
}

TEST_CASE("on a terminal no first line is wider than it, and names keep both ends") {
  Report report = mixed();
  report.outcomes[0].gate.name = "a-very-long-name-of-a-bracket-that-no-terminal-has-room-for-and-ends-in-left";
  report.outcomes[1].gate.name = "a-very-long-name-of-a-bracket-that-no-terminal-has-room-for-and-ends-in-right";
  for (const unsigned columns : {100U, 80U}) {
    const std::string table = to_table(report, {false, false, columns});
    CAPTURE(table);
    CHECK(table.find("left  ") != std::string::npos);
    CHECK(table.find("right  ") != std::string::npos);
    CHECK(table.find("at most 0.05 mm") != std::string::npos);
    for (std::size_t from = 0, to; (to = table.find('\n', from)) != std::string::npos; from = to + 1) {
      const std::string_view line(table.data() + from, to - from);
      if (!line.starts_with("    ")) CHECK(line.size() <= columns + 1);  // one letter has two bytes
    }
  }
}

TEST_CASE("colour adds nothing but colours") {
  std::string table = to_table(mixed(), {true, false});
  CHECK(table.find("\033[31mFAIL ") != std::string::npos);
  CHECK(table.find("\033[33mFAIL (warning)") != std::string::npos);
  CHECK(table.find("\033[32mPASS") != std::string::npos);
  for (std::size_t at; (at = table.find('\033')) != std::string::npos;) table.erase(at, table.find('m', at) - at + 1);
  CHECK(table == to_table(mixed(), {}));
}

TEST_CASE("quiet: gates that pass are left out") {
  const std::string table = to_table(mixed(), {false, true});
  CHECK(table.find("bracket") == std::string::npos);
  CHECK(table.find("slow") != std::string::npos);
  Report good;
  good.outcomes = {outcome("bracket", measured(0.01, 0.02, 0.05))};
  CHECK(to_table(good, {false, true}).empty());
}

TEST_CASE("a share of the diagonal stands beside the length that it came to") {
  Report report;
  report.outcomes = {outcome("share", measured(0.01, 0.02, 0.05))};
  set_share_of_diagonal(report.outcomes[0].gate, 0.005);
  CHECK(to_table(report, {}).find("at most 0.05 (0.5 % of the baseline's diagonal)") != std::string::npos);
}

TEST_CASE("a name cannot command the terminal") {
  Report report;
  report.outcomes = {outcome("a\033[2Jb\nc", measured(0.01, 0.02, 0.05))};
  CHECK(to_table(report, {}).find("a\\x1B[2Jb\\nc") != std::string::npos);
}

TEST_CASE("without a terminal each gate is a line when it ends") {
  Output out;
  ProgressDisplay display(out.file, 0, false);
  const Standing standing{3, 1, {}};
  display.show(standing);
  CHECK(out.all().empty());
  display.ended(outcome("bracket", measured(0.01, 0.02, 0.05)), standing, Undecided::separate);
  display.clear();
  CHECK(out.all() == "[1/3] PASS  bracket  0.01 .. 0.02 mm  1.25 s\n");
}

TEST_CASE("on a terminal a bar and the running gates, drawn over each other and gone at the end") {
  Output out;
  ProgressDisplay display(out.file, 60, false);
  const Gate reading = gate("first.stl", "b.stl", 1), measuring = gate("second.stl", "b.stl", 1);
  const Standing standing{4, 2, {{&reading, {}, 100}, {&measuring, {0.25, 0.5, "reduce"}, 2500}}};
  display.show(standing);
  const std::string drawn = out.all();
  CHECK(drawn ==
        "[############............] 2 of 4 gates\n"
        "  first.stl  reading  0.10 s\n"
        "  second.stl  0.25 .. 0.5  reduce  2.50 s\n");
  display.show(standing);
  CHECK(out.all() == drawn + "\r\033[3A\033[J" + drawn);
  display.ended(outcome("bracket", measured(0.01, 0.02, 0.05)), standing, Undecided::separate);
  CHECK(out.all() == drawn + "\r\033[3A\033[J" + drawn + "\r\033[3A\033[J");
}

TEST_CASE("only some of many running gates are shown, and long names are cut") {
  Output out;
  ProgressDisplay display(out.file, 40, false);
  Gate named = gate("a.stl", "b.stl", 1);
  named.name = std::string(100, 'x');
  display.show({20, 0, std::vector<Running>(12, {&named, {}, 0})});
  const std::string drawn = out.all();
  CHECK(drawn.find("  and 4 more\n") != std::string::npos);
  for (std::size_t from = 0, to; (to = drawn.find('\n', from)) != std::string::npos; from = to + 1) {
    CHECK(to - from <= 40);
  }
}
