// A run for people: progress while it lasts, and a table at its end.
#pragma once

#include <cstdio>
#include <string>

#include "check/outcome.h"
#include "check/run/run.h"

namespace meshgauge::check {

struct TableStyle {
  bool colour = false;
  bool only_not_ok = false;  // leave out what passes, and the counts when everything does
};

// Verdict, gate, interval against limit, time; below that where a failed gate failed and what to do. Ends with counts.
// Empty where `only_not_ok` leaves nothing.
std::string to_table(const Report& report, const TableStyle& style);

// On a terminal a bar and the gates that run, drawn again and again in place; elsewhere a line for each gate that ends.
// For one thread.
class ProgressDisplay {
 public:
  // Borrows `out`. `columns`: of the terminal; 0: it is none.
  ProgressDisplay(std::FILE* out, unsigned columns, bool colour) : out_(out), columns_(columns), colour_(colour) {}

  void show(const Standing& standing);  // on a terminal alone
  void ended(const GateOutcome& outcome, const Standing& standing, Undecided rule);
  void say(const std::string& line);  // above what is drawn
  void clear();                       // what stands there now; before anything else is written

 private:
  std::FILE* out_;
  unsigned columns_;
  bool colour_;
  std::size_t lines_ = 0;  // drawn
};

unsigned terminal_columns(int file);  // 0: it is no terminal

}  // namespace meshgauge::check
