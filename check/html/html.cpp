#include "check/html/html.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "check/html/diagrams.h"
#include "check/html/html_gate.h"
#include "check/html/markup.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

constexpr std::array kOrder{Verdict::fail, Verdict::error, Verdict::undecided, Verdict::pass};

// Order: failures that count, then those that only warn; otherwise the order of the gates.
std::vector<std::size_t> by_urgency(const Report& report) {
  std::vector<std::size_t> order(report.outcomes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto rank = [&](std::size_t i) {
    const GateOutcome& outcome = report.outcomes[i];
    const auto verdict = std::find(kOrder.begin(), kOrder.end(), outcome.verdict()) - kOrder.begin();
    return std::pair(outcome.level(report.undecided) != Level::failure, verdict);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  return order;
}

std::string phrase(Verdict verdict, std::size_t count) {
  const bool one = count == 1;
  switch (verdict) {
    case Verdict::pass:
      return one ? "passes" : "pass";
    case Verdict::fail:
      return one ? "fails" : "fail";
    case Verdict::undecided:
      return one ? "is undecided" : "are undecided";
    case Verdict::error:
      return "could not be measured";
  }
  return "";
}

// "2 of 5 gates fail, 1 could not be measured"
std::string headline(const Report& report) {
  const std::size_t all = report.outcomes.size();
  if (all == 0) return "No gate was checked";
  if (report.count(Verdict::pass) == all)
    return all == 1 ? "The gate passes" : "All " + std::to_string(all) + " gates pass";
  std::string text;
  for (const Verdict verdict : kOrder) {
    const std::size_t count = report.count(verdict);
    if (count == 0 || verdict == Verdict::pass) continue;
    const std::string some = std::to_string(count);
    if (!text.empty())
      text += ", " + some + " ";
    else
      text = all == 1 ? "The gate " : some + " of " + std::to_string(all) + " gates ";
    text += phrase(verdict, count);
  }
  return text;
}

// The worst result, since titles of windows are short.
std::string title(const Report& report) {
  const std::string all = headline(report);
  return all.substr(0, all.find(','));
}

std::string consequence(const Report& report) {
  const int code = report.exit_code();
  const std::string exit = "Exit code " + std::to_string(code);
  if (report.interrupted) return "The run was interrupted. " + exit + ".";
  if (code != 0) return exit + ": this stops a pipeline.";
  const bool warns = report.count(Verdict::pass) != report.outcomes.size();
  return exit + (warns ? ": what is not passed only warns." : ".");
}

std::string_view overall(const Report& report) {
  constexpr std::array<std::string_view, 4> kKinds{"pass", "fail", "undecided", "error"};
  const bool warns = report.exit_code() == 0 && report.count(Verdict::pass) != report.outcomes.size();
  return warns ? "undecided" : kKinds[static_cast<std::size_t>(report.exit_code())];
}

Verdict overall_verdict(const Report& report) {
  for (const Verdict verdict : kOrder) {
    if (to_string(verdict) == overall(report)) return verdict;
  }
  return Verdict::pass;
}

std::string head(const Report& report) {
  const std::string style(report_style());
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'sha256-" +
         sha256_base64(style) +
         "'; img-src data:; base-uri 'none'; form-action 'none'\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"referrer\" content=\"no-referrer\">\n"
         "<title>" +
         title(report) + " \xC2\xB7 meshgauge</title>\n<style>" + style + "</style>\n</head>\n";
}

// Strip of the whole run: each verdict as wide as its share.
std::string strip(const Report& report) {
  std::string out;
  double from = 0;
  for (const Verdict verdict : kOrder) {
    const double share = static_cast<double>(report.count(verdict)) / static_cast<double>(report.outcomes.size());
    if (share > 0) {
      out += "<rect class=\"" + std::string(to_string(verdict)) + "\" x=\"" + to_digits(100 * from, 6) +
             "%\" width=\"" + to_digits(100 * share, 6) + "%\" height=\"10\"/>";
    }
    from += share;
  }
  return "<svg class=\"strip\" width=\"100%\" height=\"10\" aria-hidden=\"true\">" + out + "</svg>\n";
}

std::string choice(const std::string& id, const std::string& label, bool chosen) {
  return "<input type=\"radio\" name=\"show\" id=\"show-" + id + "\"" + (chosen ? " checked" : "") +
         "><label for=\"show-" + id + "\">" + label + "</label>\n";
}

// Radio buttons that the style sheet evaluates, without script.
std::string filter(const Report& report) {
  std::string out = "<fieldset class=\"filter\"><legend>Show</legend>\n" +
                    choice("all", "All <b>" + std::to_string(report.outcomes.size()) + "</b>", true);
  for (const Verdict verdict : kOrder) {
    const std::size_t count = report.count(verdict);
    const std::string name(to_string(verdict));
    if (count > 0) {
      out += choice(
          name,
          "<span class=\"" + name + "\">" + icon(verdict) + "</span>" + name + " <b>" + std::to_string(count) + "</b>",
          false);
    }
  }
  return out + "</fieldset>\n";
}

// The row of one criterion, below that of its gate. An expectation has words alone.
std::string criterion_row(const CriterionWords& row, const std::string& kind_of_gate) {
  const std::string kind(to_string(row.criterion.verdict));
  const bool is_expectation = row.criterion.of == Criterion::Of::expectation;
  return "<tr class=\"gate criterion " + kind_of_gate + "\"><td><span class=\"badge " + kind + "\">" +
         icon(verdict_of(row.criterion.verdict)) + kind + "</span></td><th scope=\"row\">" + escaped(row.name) +
         "</th><td class=\"number" + (is_expectation ? " words" : "") + "\">" + escaped(row.interval) +
         "</td><td class=\"number limit" + (is_expectation ? " expected words" : "") + "\">" + escaped(row.limit) +
         "</td><td class=\"wide\">" + (is_expectation ? "" : interval_line(row.criterion)) + "</td></tr>\n";
}

// All limits where there are several, and each expectation that is not met.
std::string criterion_rows(const GateOutcome& outcome, const std::string& kind_of_gate) {
  std::string out;
  const auto limits = criteria_in_words(outcome);
  const auto unmet = [](const Criterion& one) { return one.verdict != api::Verdict::pass; };
  const bool has_unmet = std::ranges::any_of(outcome.expectations, unmet);
  if (limits.size() > 1 || has_unmet) {
    for (const CriterionWords& one : limits) out += criterion_row(one, kind_of_gate);
  }
  for (const Criterion& one : outcome.expectations) {
    if (unmet(one)) out += criterion_row({one.name, one.found, "expected " + one.expected, one}, kind_of_gate);
  }
  return out;
}

std::string index_row(const GateOutcome& outcome, std::size_t index) {
  const std::string kind(to_string(outcome.verdict()));
  const std::string out = "<tr class=\"gate " + kind + "\"><td><span class=\"badge " + kind + "\">" +
                          icon(outcome.verdict()) + kind + "</span></td><th scope=\"row\"><a href=\"#" +
                          gate_id(index) + "\">" + escaped(outcome.gate.name) + "</a></th><td class=\"number\">" +
                          (outcome.measured ? escaped(interval_of(outcome)) : "none") +
                          "</td><td class=\"number limit\">" + escaped(limit_of(outcome)) + "</td><td class=\"wide\">" +
                          (outcome.measured ? interval_line(outcome.measured->foremost()) : "") + "</td></tr>\n";
  return out + criterion_rows(outcome, kind);
}

std::string index_of(const Report& report, const std::vector<std::size_t>& order) {
  std::string out =
      "<nav aria-label=\"Gates\"><div class=\"scroll\"><table class=\"index\">"
      "<caption class=\"unseen\">All gates, failures first</caption><thead><tr><th scope=\"col\">Verdict</th>"
      "<th scope=\"col\">Gate</th><th scope=\"col\">Distance</th><th scope=\"col\">Limit</th>"
      "<th scope=\"col\" class=\"centred\">Share of the limit</th></tr></thead><tbody>\n";
  for (const std::size_t i : order) out += index_row(report.outcomes[i], i);
  return out + "</tbody></table></div></nav>\n";
}

std::string banner(const Report& report) {
  std::string out = "<header class=\"banner " + std::string(overall(report)) +
                    "\">\n<p class=\"brand\">meshgauge check</p>\n<h1>" + icon(overall_verdict(report)) +
                    headline(report) + "</h1>\n<p>" + consequence(report) + "</p>\n";
  if (report.against)
    out += "<p class=\"muted\">Baselines are those of " + escaped(report.against->in_words()) + ".</p>\n";
  return out + (report.outcomes.empty() ? "" : strip(report)) + "</header>\n";
}

std::string what_is_left_out(std::span<const GatePicture> pictures) {
  const auto count = [&](const auto& is) {
    return static_cast<std::size_t>(std::count_if(pictures.begin(), pictures.end(), is));
  };
  const std::size_t left_out = count([](const GatePicture& p) { return p.left_out; });
  if (left_out == 0) return "";
  const std::size_t drawn = count([](const GatePicture& p) { return !p.surfaces.empty(); });
  const std::size_t undrawn = count([](const GatePicture& p) { return !p.missing.empty(); });
  return "<p class=\"note\">Tables and witnesses of " + grouped(drawn + undrawn) +
         (drawn + undrawn == 1 ? " gate" : " gates") + ", pictures of " + grouped(drawn) +
         ": those that fail, then the undecided, then those that come nearest to their limits. Of " +
         grouped(left_out) + (left_out == 1 ? " other" : " others") +
         ", the interval and the limit; the report as JSON has all numbers.</p>\n";
}

std::string footer(const Report& report, std::span<const GatePicture> pictures) {
  std::size_t shots = 0, bytes = 0;
  const auto count = [&](const Shot& shot) { ++shots, bytes += shot.png.size(); };
  for (const GatePicture& picture : pictures) {
    for (const Surface& surface : picture.surfaces) {
      count(surface.whole);
      if (surface.close_up) count(*surface.close_up);
    }
  }
  return "<footer><p>Intervals and verdicts are certified: the Hausdorff distance lies between the two bounds, "
         "rounding included. Colours and histograms are not; they show where to look. Of the gates that pass, those "
         "nearest to their limits have one small picture, every other gate large pictures and close-ups: " +
         grouped(shots) + (shots == 1 ? " picture" : " pictures") + ", " + in_bytes(bytes) + ".</p><p>meshgauge " +
         escaped(report.version) + ". This file is complete: it loads nothing and runs no script.</p></footer>\n";
}

}  // namespace

std::string to_html(const Report& report, std::span<const GatePicture> pictures) {
  const std::vector<std::size_t> order = by_urgency(report);
  std::string out = head(report) + "<body>\n<a class=\"skip\" href=\"#gates\">Skip to the gates</a>\n" + definitions() +
                    banner(report);
  out += "<main id=\"gates\">\n";
  if (!order.empty()) out += what_is_left_out(pictures) + filter(report) + index_of(report, order);
  for (const std::size_t i : order) {
    out += gate_card(report.outcomes[i], i < pictures.size() ? &pictures[i] : nullptr, i, report.undecided);
  }
  return out + "</main>\n" + footer(report, pictures) + "</body>\n</html>\n";
}

}  // namespace meshgauge::check
