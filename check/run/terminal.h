// Prints a run on a terminal: progress while it lasts, and a table at its end.
#pragma once

#include <cstdio>
#include <string>

#include "check/outcome.h"
#include "check/run/run.h"

namespace meshgauge::check {

struct TableStyle {
  bool colour = false;
  bool only_not_ok = false;  // leave out gates that pass and were measured whole, and the counts if all do
  unsigned columns = 0;      // width of the terminal; 0: not a terminal
};

// Returns a line for each gate (verdict, name, interval against limit, time), below it each of several limits, what is
// expected and not met, where a failed gate failed and what to do, and at the end the counts. On a terminal the first
// lines are no wider than it: names are shortened in the middle, and where that is not enough the limits stand below.
// Empty if `only_not_ok` leaves nothing.
std::string to_table(const Report& report, const TableStyle& style);

// On a terminal: a bar and the running gates, drawn in place. Elsewhere: a line for each gate that ends. For one
// thread.
class ProgressDisplay {
 public:
  // Borrows `out`. `columns`: width of the terminal; 0: not a terminal.
  ProgressDisplay(std::FILE* out, unsigned columns, bool colour) : out_(out), columns_(columns), colour_(colour) {}

  void show(const Standing& standing);  // does nothing without a terminal
  void ended(const GateOutcome& outcome, const Standing& standing, Undecided rule);
  void say(const std::string& line);  // prints a line above the display
  void clear();                       // removes the display; call before writing anything else

 private:
  std::FILE* out_;
  unsigned columns_;
  bool colour_;
  std::size_t lines_ = 0;  // lines of the display
};

unsigned terminal_columns(int file);  // 0: not a terminal

// Whether GitHub Actions runs this, which takes lines of its log for commands.
bool is_on_github();
// Returns text for standard output or error, as it is. On GitHub Actions what would be a command there, "##[" in a line
// and "::" at its beginning, has an escape in it: names of files and gates are foreign text.
std::string for_log(std::string text);

}  // namespace meshgauge::check
