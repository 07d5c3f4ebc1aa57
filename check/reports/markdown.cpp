#include "check/reports/reports.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "check/picture_name.h"
#include "check/reports/earlier.h"
#include "check/reports/history.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

constexpr int kBarCells = 24;
constexpr std::size_t kNameBytes = 300;    // of a name; a path may have 4096 bytes
constexpr std::size_t kProseBytes = 2000;  // of a sentence
constexpr std::size_t kReserved = 400;     // room for the end of a fold and the line about what is left out
constexpr std::size_t kChanges = 20;       // shown of those since an earlier run

// A comment has the limits that are kept in its fold, and says where pictures belong.
enum class Form { summary, comment };

// Code span for a table. '|' would end the cell and a backslash before it is read differently by each forge, so it is
// escaped. The fence is longer than any run of backticks inside.
std::string code(const std::string& name) {
  std::string body;
  std::size_t run = 0, longest = 0;
  for (const char c : cut_at(shown_name(name), kNameBytes)) {
    body += c == '|' ? std::string("\\x7C") : std::string(1, c);
    run = c == '`' ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  const std::string fence(longest + 1, '`');
  const bool padded = body.front() == '`' || body.back() == '`' || body.front() == ' ' || body.back() == ' ';
  return padded ? fence + " " + body + " " + fence : fence + body + fence;
}

bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         std::string_view(" .,;?()'\"/").find(c) != std::string_view::npos;
}

// Whether a forge makes a reference of it, as in "@name", "#12" or "!3". An invisible word joiner is written after
// it.
bool begins_reference(char c) { return std::string_view("@#!$%~&:^").find(c) != std::string_view::npos; }

std::string entity(char c) { return "&#" + std::to_string(static_cast<unsigned char>(c)) + ";"; }

// Escapes text for a sentence. Entities are shown as characters, never read as Markdown or HTML.
std::string in_prose(const std::string& whole) {
  std::string out;
  const std::string text = cut_at(whole, kProseBytes);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool address = c == 'w' && text.compare(i, 4, "www.") == 0;  // forges make a link of it
    if (c == '\n' || c == '\t') {
      out += ' ';
    } else if (static_cast<unsigned char>(c) >= 0x80 || (is_plain(c) && !address)) {
      out += c;
    } else {
      out += entity(c);
    }
    const bool word_follows = i + 1 < text.size() && text[i + 1] != ' ';
    if (begins_reference(c) && word_follows) out += "&#8288;";
  }
  return out;
}

// Escapes text for the beginning of a line, where a digit or a blank could begin a list or a block of code.
std::string paragraph(const std::string& text) {
  const std::string out = in_prose(text);
  const bool plain = !out.empty() && out[0] != ' ' && std::isdigit(static_cast<unsigned char>(out[0])) == 0;
  return plain || out.empty() ? out : entity(out[0]) + out.substr(1);
}

// Draws interval and limit on a scale from 0. The cells agree with the verdict however near the limit is.
std::string bar_of(const Criterion& criterion) {
  const double end =
      1.25 * std::max(criterion.limit, std::isfinite(criterion.upper) ? criterion.upper : criterion.lower);
  const auto cell = [&](double x) {
    return end > 0 && std::isfinite(x) ? std::clamp(x / end, 0.0, 1.0) * kBarCells : kBarCells;
  };
  const int limit = std::clamp(static_cast<int>(cell(criterion.limit)), 1, kBarCells - 1);
  int first = criterion.lower > 0 ? std::min(static_cast<int>(cell(criterion.lower)), kBarCells - 1) : 0;
  int last = criterion.upper > 0 ? std::max(static_cast<int>(std::ceil(cell(criterion.upper))), first + 1)
                                 : 1;  // at least one cell after it
  if (criterion.verdict == api::Verdict::pass) {
    last = std::min(last, limit);
    first = std::min(first, last - 1);
  } else if (criterion.verdict == api::Verdict::fail) {
    first = std::max(first, limit);
    last = std::max(last, first + 1);
  } else if (criterion.lower <= criterion.limit && criterion.upper > criterion.limit) {
    first = std::min(first, limit - 1);
    last = std::max(last, limit + 1);
  }
  std::string bar;
  for (int i = 0; i < kBarCells; ++i) {
    if (i == limit) bar += "│";
    bar += i >= first && i < last ? "█" : "·";
  }
  return "`" + bar + "`";
}

struct Row {
  const GateOutcome* outcome;
  Level level;
};

const char* icon_of(const Row& row) {
  if (row.level == Level::ok) return "✅";
  if (row.level == Level::warning) return "⚠️";
  return row.outcome->verdict() == Verdict::undecided ? "❔" : "❌";
}

// Order: the worst first; equal ones in the order of the manifest.
int rank_of(const Row& row) {
  if (row.level == Level::ok) return 4;
  if (row.level == Level::warning) return 3;
  const Verdict verdict = row.outcome->verdict();
  return verdict == Verdict::error ? 0 : verdict == Verdict::fail ? 1 : 2;
}

std::vector<Row> rows_of(const Report& report) {
  std::vector<Row> rows;
  for (const GateOutcome& outcome : report.outcomes) rows.push_back({&outcome, outcome.level(report.undecided)});
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return rank_of(a) < rank_of(b); });
  return rows;
}

std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string title_of(const Report& report, const std::vector<Row>& rows) {
  const int exit_code = report.exit_code();
  const char* const words[] = {"all gates hold", "failed", "undecided", "not everything could be measured"};
  const char* const icons[] = {"✅", "❌", "❔", "❌"};
  std::string title = std::string("## ") + icons[exit_code] + " meshgauge: " + words[exit_code] + "\n\n";
  title += counted(report.outcomes.size(), "gate", "gates") + ": " + std::to_string(report.count(Verdict::pass)) +
           " passed, " + std::to_string(report.count(Verdict::fail)) + " failed, " +
           std::to_string(report.count(Verdict::undecided)) + " undecided, " +
           counted(report.count(Verdict::error), "error", "errors") + ".";
  const auto allowed = std::count_if(rows.begin(), rows.end(), [](const Row& r) { return r.level == Level::warning; });
  if (allowed > 0) title += " " + std::to_string(allowed) + " of them only warn.";
  if (report.interrupted) title += " The run was interrupted.";
  if (report.against) title += " Baselines are those of " + code(report.against->in_words()) + ".";
  return title + "\n";
}

// Lists only some, since the rest of the page must fit.
std::string batches_of(const Report& report) {
  if (report.batches.empty()) return "";
  const std::size_t count = report.batches.size(), shown = std::min<std::size_t>(count, 3);
  std::string text = "\nSee them at the service, as long as it keeps the results: ";
  for (std::size_t i = 0; i < shown; ++i) {
    text += (i == 0 ? "[batch " : ", [batch ") + std::to_string(i + 1) + "](<" + report.batches[i] + ">)";
  }
  return text + (count > shown ? " and " + std::to_string(count - shown) + " more" : "") + "\n";
}

// What is not as it was in the run of --since.
std::string changes_of(const Report& report) {
  if (!report.since) return "";
  const std::string since = " since " + code(report.since->name);
  if (!report.since->problem.empty())
    return "\nWhat changed" + since + " is not known: " + in_prose(shown_name(report.since->problem)) + ".\n";
  const std::vector<Change> changes = changes_since(*report.since, report);
  if (changes.empty()) return "\nNothing changed" + since + ".\n";
  std::string text = "\nChanged" + since + ":\n\n| gate | before | now |\n|---|---|---|\n";
  for (std::size_t i = 0; i < std::min(changes.size(), kChanges); ++i) {
    const Change& change = changes[i];
    text += "| " + code(change.gate) + " | " + (change.before.empty() ? "new" : in_prose(change.before)) + " | " +
            (change.now.empty() ? "gone" : in_prose(change.now)) + " |\n";
  }
  if (changes.size() > kChanges) text += "\nAnd " + counted(changes.size() - kChanges, "other", "others") + ".\n";
  return text;
}

constexpr const char* kTable =
    "\n| | gate | distance | limit | `│` is the limit, `█` where the distance is |\n|---|---|---|---|---|\n";

std::string line_of(const GateOutcome& outcome, const CriterionWords& one) {
  return "| " + std::string(to_string(one.criterion.verdict)) + " | " + code(outcome.gate.name) + ": " +
         in_prose(one.name) + " | " + in_prose(one.interval) + " | " + in_prose(one.limit) + " | " +
         bar_of(one.criterion) + " |\n";
}

bool is_kept(const CriterionWords& one) { return one.criterion.verdict == api::Verdict::pass; }

// The gate, and each of its limits where it has several; in a comment those of an open gate that are not kept.
std::string line_of(const Row& row, Form form) {
  const GateOutcome& outcome = *row.outcome;
  std::string verdict(to_string(outcome.verdict()));
  if (outcome.measured && !outcome.measured->link.empty())
    verdict = "[" + verdict + "](<" + outcome.measured->link + ">)";
  std::string line = std::string("| ") + icon_of(row) + " " + verdict + " | " + code(outcome.gate.name) + " | " +
                     in_prose(interval_of(outcome)) + " | " + in_prose(limit_of(outcome)) + " | ";
  if (!outcome.measured) return line + " |\n";
  line += bar_of(outcome.measured->foremost()) + " |\n";
  const auto all = criteria_in_words(outcome);
  if (all.size() < 2) return line;
  for (const CriterionWords& one : all) {
    if (form == Form::summary || row.level == Level::ok || !is_kept(one)) line += line_of(outcome, one);
  }
  return line;
}

// The limits that line_of() leaves out of a comment.
std::vector<std::string> kept_lines(const std::vector<Row>& open) {
  std::vector<std::string> lines;
  for (const Row& row : open) {
    const auto all = criteria_in_words(*row.outcome);
    for (const CriterionWords& one : all) {
      if (all.size() > 1 && is_kept(one)) lines.push_back(line_of(*row.outcome, one));
    }
  }
  return lines;
}

std::string sentence_of(const GateOutcome& outcome) {
  std::string sentence = finding_of(outcome);
  if (!outcome.measured) return sentence;
  sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
  return sentence + ".";
}

std::string picture_mark(const GateOutcome& outcome) {
  return "<!-- picture: " + picture_name(outcome.gate.name) + " -->";
}

// "last 5 runs of the distance, the limit is the height of `▅`: `▂▂▃▄▆`" for each limit; none without --history.
std::vector<std::string> courses_of(const GateOutcome& outcome) {
  std::vector<std::string> courses;
  for (const Chart& chart : charts_of(outcome)) {
    if (const std::string runs = sparkline(chart.runs); !runs.empty())
      courses.push_back("last " + std::to_string(chart.runs.size()) + " runs of " + in_prose(chart.what) +
                        ", the limit" + margin_of(chart) + " is the height of `▅`: `" + runs + "`");
  }
  return courses;
}

std::string section_of(const Row& row, Form form) {
  const GateOutcome& outcome = *row.outcome;
  std::string text = std::string("\n### ") + icon_of(row) + " " + code(outcome.gate.name) + "\n\n";
  text += paragraph(sentence_of(outcome)) + "\n";
  if (const std::string advice = advice_of(outcome); !advice.empty()) text += "\n" + paragraph(advice) + "\n";
  // What posts the comment knows whether there is a picture, and its address.
  if (form == Form::comment && outcome.measured) text += "\n" + picture_mark(outcome) + "\n";
  text += "\n";
  if (outcome.measured && !outcome.measured->link.empty()) {
    text += "- [See the difference](<" + outcome.measured->link + ">), as long as the service keeps the result\n";
  }
  if (const std::string witness = witness_of(outcome); !witness.empty())
    text += "- witness " + in_prose(witness) + "\n";
  for (const std::string& course : courses_of(outcome)) text += "- " + course + "\n";
  for (const std::string& note : notes_of(outcome)) text += "- note: " + in_prose(note) + "\n";
  const Gate& gate = outcome.gate;  // a mistake of the manifest has no files
  if (!gate.candidate.empty()) text += "- candidate " + code(gate.candidate.string()) + "\n";
  if (!gate.baseline.empty()) text += "- baseline " + code(gate.baseline.string()) + "\n";
  if (const std::string source = source_of(outcome.gate); !source.empty()) text += "- gate " + code(source) + "\n";
  return text;
}

// Adds parts while they fit and counts the others.
class Page {
 public:
  explicit Page(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  bool add(const std::string& part) {
    if (full_ || text_.size() + part.size() + kReserved > max_bytes_) return full_ = true, false;
    text_ += part;
    return true;
  }
  bool full() const { return full_; }
  void close(const std::string& part) { text_ += part; }  // uses the room of kReserved

  std::string take() && { return std::move(text_); }

 private:
  std::string text_;
  std::size_t max_bytes_;
  bool full_ = false;
};

// Returns the number of rows that did not fit. `more`: lines behind those of the rows.
std::size_t add_table(Page& page, const std::vector<Row>& rows, Form form, const std::vector<std::string>& more = {}) {
  if (rows.empty() && more.empty()) return 0;
  std::size_t written = 0;
  if (page.add(kTable)) {
    while (written < rows.size() && page.add(line_of(rows[written], form))) ++written;
    for (const std::string& line : more) page.add(line);
  }
  return rows.size() - written;
}

// "3 gates and 2 limits of others passed"
std::string title_of_fold(std::size_t gates, std::size_t limits) {
  if (gates == 0) return counted(limits, "limit", "limits") + " passed";
  const std::string others = limits > 0 ? " and " + counted(limits, "limit", "limits") + " of others" : "";
  return counted(gates, "gate", "gates") + others + " passed";
}

// A candidate that was moved is named, and what was not measured, also where the gate passes.
std::vector<std::string> notes_of_passed(const GateOutcome& outcome) {
  std::vector<std::string> notes;
  for (const std::string& note : unmeasured_of(outcome)) notes.push_back(in_prose(note));
  const auto& measured = outcome.measured;
  if (measured->motion && !measured->notes.empty()) notes.push_back(in_prose(shown_name(measured->notes.front())));
  return notes;
}

// A list of what is said of the gates that pass: first all notes, since the page may end in it.
void add_list(Page& page, const std::vector<Row>& rows) {
  const char* before = "\n";
  for (const auto& said_of : {notes_of_passed, courses_of}) {
    for (const Row& row : rows) {
      for (const std::string& said : said_of(*row.outcome)) {
        if (!page.add(before + ("- " + code(row.outcome->gate.name)) + ": " + said + "\n")) return;
        before = "";
      }
    }
  }
}

std::string to_text(const Report& report, Form form, std::size_t max_bytes) {
  const std::vector<Row> rows = rows_of(report);
  const auto is_ok = [](const Row& row) { return row.level == Level::ok; };
  const auto first_ok = std::find_if(rows.begin(), rows.end(), is_ok);
  const std::vector<Row> open(rows.begin(), first_ok), passed(first_ok, rows.end());

  Page page(max_bytes);
  page.add(title_of(report, rows));
  page.add(batches_of(report));
  page.add(changes_of(report));
  std::size_t left_out = add_table(page, open, form);
  for (const Row& row : open) {
    if (!page.add(section_of(row, form))) break;
  }
  const std::vector<std::string> kept = form == Form::comment ? kept_lines(open) : std::vector<std::string>();
  if (passed.size() + kept.size() > 0 &&
      page.add("\n<details><summary>" + title_of_fold(passed.size(), kept.size()) + "</summary>\n")) {
    left_out += add_table(page, passed, form, kept);
    add_list(page, passed);
    page.close("\n</details>\n");
  } else {
    left_out += passed.size();
  }
  if (left_out > 0) page.close("\n" + counted(left_out, "more gate", "more gates") + " found no room here.\n");
  if (left_out == 0 && page.full()) page.close("\nNot all details found room here.\n");
  return std::move(page).take();
}

}  // namespace

std::string to_markdown(const Report& report, std::size_t max_bytes) {
  return to_text(report, Form::summary, max_bytes);
}

std::string to_comment(const Report& report, std::size_t max_bytes) {
  return to_text(report, Form::comment, max_bytes);
}

}  // namespace meshgauge::check
