#include "check/run/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <vector>

#include "api/base/text.h"
#include "api/base/utf8.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kMostShown = 8;  // gates below the bar
constexpr std::size_t kBarWidth = 24;

// Red for a failure, yellow for a warning.
const char* colour_of(Verdict verdict, Level level) {
  if (level == Level::warning) return "\033[33m";
  if (verdict == Verdict::pass) return "\033[32m";
  return verdict == Verdict::undecided ? "\033[35m" : "\033[31m";
}

std::string coloured(const std::string& text, const char* colour, bool on) {
  return on ? colour + text + "\033[0m" : text;
}

// Counts characters, not bytes.
std::size_t width_of(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::count_if(text.begin(), text.end(), is_within_character));
}

std::string padded(std::string text, std::size_t width) {
  const auto has = width_of(text);
  return text.append(width > has ? width - has : 0, ' ');
}

std::string cut_to(const std::string& text, std::size_t width) {
  if (width_of(text) <= width) return text;
  std::size_t end = 0, letters = 0;
  for (; end < text.size(); ++end) {
    if (!is_within_character(text[end]) && letters++ + 1 == width) break;
  }
  return text.substr(0, end) + "~";
}

// "a-long-~me.stl". Precondition: width >= 3.
std::string shortened(const std::string& text, std::size_t width) {
  const std::size_t has = width_of(text);
  if (has <= width) return text;
  std::size_t begin = 0, skipped = 0;
  const std::size_t head = width / 2, tail = width - head - 1;
  for (; begin < text.size(); ++begin) {
    if (!is_within_character(text[begin]) && skipped++ == has - tail) break;
  }
  return cut_to(text, head + 1) + text.substr(begin);
}

std::string time_text(double ms) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, ms < 10'000 ? "%.2f s" : "%.0f s", ms / 1000);
  return buffer;
}

std::string verdict_text(const GateOutcome& outcome, Undecided rule) {
  std::string text(to_string(outcome.verdict()));
  std::transform(text.begin(), text.end(), text.begin(), [](char c) { return static_cast<char>(c - 'a' + 'A'); });
  if (outcome.level(rule) == Level::warning) text += " (warning)";
  return text;
}

struct Line {
  std::string verdict, name, interval, limit, time, advice;
  std::vector<std::string> notes;
  std::vector<std::string> criteria;
  const char* colour;
};

// "fail       distance in bore: 0.0201 .. 0.0203 mm, at most 0.02 mm", none for a gate of one limit, whose row says it;
// and each expectation that is not met.
std::vector<std::string> criterion_lines(const GateOutcome& outcome) {
  std::vector<std::string> lines;
  const auto add = [&](api::Verdict verdict, const std::string& what) {
    lines.push_back(padded(std::string(to_string(verdict)), std::string_view("undecided").size()) + "  " + what);
  };
  const auto all = criteria_in_words(outcome);
  for (const CriterionWords& one : all) {
    if (all.size() > 1) add(one.criterion.verdict, one.name + ": " + one.interval + ", at most " + one.limit);
  }
  for (const Criterion& one : outcome.expectations) {
    if (one.verdict != api::Verdict::pass)
      add(one.verdict, one.name + ": " + shown_name(one.found) + ", expected " + shown_name(one.expected));
  }
  return lines;
}

Line shown_line(const GateOutcome& outcome, Undecided rule) {
  return {verdict_text(outcome, rule),
          shown_name(outcome.gate.name),
          outcome.measured ? interval_of(outcome) : "-",
          "at most " + limit_of(outcome),
          time_text(outcome.wall_ms),
          outcome.advice().empty() ? "" : shown_name(outcome.advice()),
          notes_of(outcome),
          criterion_lines(outcome),
          colour_of(outcome.verdict(), outcome.level(rule))};
}

std::string count_text(const Report& report) {
  std::string text = std::to_string(report.outcomes.size()) + (report.outcomes.size() == 1 ? " gate: " : " gates: ");
  bool first = true;
  for (const auto verdict : {Verdict::pass, Verdict::fail, Verdict::undecided, Verdict::error}) {
    const auto count = report.count(verdict);
    if (count == 0) continue;
    text += (first ? "" : ", ") + std::to_string(count) + " " + std::string(to_string(verdict));
    first = false;
  }
  if (report.against) text += "; against " + shown_name(report.against->in_words());
  return text + (report.interrupted ? "; interrupted" : "") + "\n";
}

std::string line_of(const Line& row, const Line& widest, bool colour) {
  std::string line = coloured(padded(row.verdict, widest.verdict.size()), row.colour, colour) + "  " +
                     padded(row.name, width_of(widest.name)) + "  " + padded(row.interval, widest.interval.size());
  if (!widest.limit.empty()) line += "  " + padded(row.limit, width_of(widest.limit));
  line += "  " + row.time + "\n";
  if (widest.limit.empty()) line += "    " + row.limit + "\n";
  for (const std::string& criterion : row.criteria) line += "    " + criterion + "\n";
  if (!row.advice.empty()) line += "    " + row.advice + "\n";
  for (const std::string& note : row.notes) line += "    note: " + note + "\n";
  return line;
}

// Returns the width of the widest text of each column.
Line widths(const std::vector<Line>& rows) {
  Line widest{};
  for (const Line& row : rows) {
    for (auto column : {&Line::verdict, &Line::name, &Line::interval, &Line::limit}) {
      if (width_of(row.*column) > width_of(widest.*column)) widest.*column = row.*column;
    }
  }
  return widest;
}

// Makes the first lines of all rows as narrow as the terminal, as far as a name can still be told from another.
void fit(std::vector<Line>& rows, Line& widest, std::size_t columns) {
  constexpr std::size_t kLeastName = 24, kTime = 8;
  const auto room = [&] {
    const std::size_t others = widest.verdict.size() + width_of(widest.interval) + width_of(widest.limit) + kTime + 8;
    return columns > others ? columns - others : 0;
  };
  const std::size_t wanted = std::min(width_of(widest.name), kLeastName);
  if (room() < wanted) widest.limit.clear();
  const std::size_t width = std::max(room(), wanted);
  for (Line& row : rows) row.name = shortened(row.name, width);
  widest.name = shortened(widest.name, width);
}

std::string bar(const Standing& standing) {
  const auto full = standing.gates ? kBarWidth * standing.done / standing.gates : kBarWidth;
  return "[" + std::string(full, '#') + std::string(kBarWidth - full, '.') + "] " + std::to_string(standing.done) +
         " of " + std::to_string(standing.gates) + " " + standing.counted;
}

std::string line_of(const Running& running) {
  const Progress& progress = running.progress;
  const bool known = progress.upper < std::numeric_limits<double>::infinity();
  const std::string interval = known ? rounded(progress.lower) + " .. " + rounded(progress.upper) : "reading";
  return "  " + shown_name(running.gate->name) + "  " + interval +
         (known ? std::string("  ") + progress.stage : std::string()) + "  " + time_text(running.ms);
}

}  // namespace

std::string to_table(const Report& report, const TableStyle& style) {
  std::vector<Line> rows;
  for (const GateOutcome& outcome : report.outcomes) {
    const bool is_ok = outcome.level(report.undecided) == Level::ok && unmeasured_of(outcome).empty();
    if (style.only_not_ok && is_ok) continue;
    rows.push_back(shown_line(outcome, report.undecided));
  }
  if (rows.empty() && style.only_not_ok) return "";
  Line widest = widths(rows);
  if (style.columns > 0) fit(rows, widest, style.columns);
  std::string table;
  for (const Line& row : rows) table += line_of(row, widest, style.colour);
  return table + count_text(report);
}

void ProgressDisplay::show(const Standing& standing) {
  if (columns_ == 0) return;
  std::vector<std::string> lines{bar(standing)};
  for (const Running& running : standing.running) {
    if (lines.size() > kMostShown) break;
    lines.push_back(line_of(running));
  }
  if (standing.running.size() > kMostShown) {
    lines.push_back("  and " + std::to_string(standing.running.size() - kMostShown) + " more");
  }
  clear();
  for (const std::string& line : lines) std::fprintf(out_, "%s\n", cut_to(line, columns_ - 1).c_str());
  std::fflush(out_);
  lines_ = lines.size();
}

void ProgressDisplay::ended(const GateOutcome& outcome, const Standing& standing, Undecided rule) {
  clear();
  const Line row = shown_line(outcome, rule);
  const std::string place = "[" + std::to_string(standing.done) + "/" + std::to_string(standing.gates) + "] ";
  if (columns_ == 0) {
    const std::string line = place + coloured(row.verdict, row.colour, colour_) + "  " + row.name + "  " +
                             row.interval + "  " + row.time + "\n";
    std::fputs(for_log(line).c_str(), out_);
    std::fflush(out_);
  }
}

void ProgressDisplay::say(const std::string& line) {
  clear();
  std::fprintf(out_, "%s\n", for_log(line).c_str());
  std::fflush(out_);
}

void ProgressDisplay::clear() {
  if (lines_ == 0) return;
  std::fprintf(out_, "\r\033[%zuA\033[J", lines_);
  lines_ = 0;
}

unsigned terminal_columns(int file) {
  if (isatty(file) == 0) return 0;
  winsize size{};
  return ioctl(file, TIOCGWINSZ, &size) == 0 && size.ws_col > 10 ? size.ws_col : 80;
}

bool is_on_github() {
  const char* value = std::getenv("GITHUB_ACTIONS");
  return value && std::string_view(value) == "true";
}

std::string for_log(std::string text) {
  if (!is_on_github()) return text;
  api::replace_all(text, "##[", "##\\x5B");
  for (std::size_t line = 0; line < text.size(); ++line) {
    const std::size_t first = text.find_first_not_of(" \t", line);
    if (first != std::string::npos && text.compare(first, 2, "::") == 0) text.replace(first, 1, "\\x3A");
    line = std::min(text.find('\n', line), text.size());
  }
  return text;
}

}  // namespace meshgauge::check
