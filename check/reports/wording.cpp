#include "check/reports/wording.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>

#include "api/base/figures.h"
#include "api/base/utf8.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using api::with_unit;

constexpr int kDigits = 6;

std::string escape(const char* format, std::uint32_t value) {
  std::array<char, 16> text{};
  const int n = std::snprintf(text.data(), text.size(), format, value);
  return {text.data(), static_cast<std::size_t>(n)};
}

std::string escape_of(std::uint32_t c) {
  if (c == '\n') return "\\n";
  if (c == '\r') return "\\r";
  if (c == '\t') return "\\t";
  if (c < 0x80) return escape("\\x%02X", c);
  return c < 0x10000 ? escape("\\u%04X", c) : escape("\\U%08X", c);
}

std::string visible(std::string_view bytes, bool keep_lines) {
  std::string out;
  while (!bytes.empty()) {
    const Character next = decode(bytes);
    const std::size_t length = std::max<std::size_t>(next.bytes, 1);
    if (next.bytes == 0) {
      out += escape("\\x%02X", static_cast<unsigned char>(bytes[0]));
    } else if (!is_hidden(next.code) || (keep_lines && (next.code == '\n' || next.code == '\t'))) {
      out += bytes.substr(0, length);
    } else {
      out += escape_of(next.code);
    }
    bytes.remove_prefix(length);
  }
  return out;
}

std::string in_percent_of_diagonal(double share) { return to_digits(100 * share, kDigits) + " %"; }

// The limit of the distance as the gate has it: of the region, of the side, or of the gate.
double asked_for(const Gate& gate, const Criterion& criterion) {
  const std::vector<Criterion> asked = api::limits_asked(gate.request.options);
  const auto found = std::ranges::find(asked, criterion.name, &Criterion::name);
  return found == asked.end() ? 0 : found->beyond.value_or(found->limit);
}

// `number`: the limit as measured.
std::string length_in_words(const GateOutcome& outcome, const Criterion& criterion, const std::string& number) {
  const std::string length = with_unit(number, outcome.unit()), share = share_of_diagonal(outcome, criterion);
  return share.empty() ? length : length + " (" + share + " of the baseline's diagonal)";
}

// The same before the gate is measured.
std::string length_in_words(const GateOutcome& outcome, double limit) {
  return is_of_diagonal(outcome.gate) ? in_percent_of_diagonal(limit) + " of the baseline's diagonal"
                                      : with_unit(to_digits(limit, kDigits), outcome.unit());
}

// " inside"; empty: the limit is of no side.
std::string side_of(const Criterion& criterion) { return criterion.side.empty() ? "" : " " + criterion.side; }

// "0.05 mm"; "0.05 mm inside"; "1 % beyond 0.05 mm".
std::string limit_in_words(const GateOutcome& outcome, const Criterion& criterion) {
  const std::string number = figures_of(criterion).limit, more = plus_minus(criterion, outcome.unit());
  if (!criterion.beyond) return length_in_words(outcome, criterion, number) + more + side_of(criterion);
  return number + " % beyond " + length_in_words(outcome, criterion, to_digits(*criterion.beyond, kDigits)) + more;
}

std::string joined(const std::string& one, const std::string& other, const char* by) {
  return one.empty() || other.empty() ? one + other : one + by + other;
}

std::string finding_of(const GateOutcome& outcome, const Criterion& criterion) {
  return shown_name(
      api::finding_of(criterion, outcome.unit(), criterion.beyond ? "" : limit_in_words(outcome, criterion)));
}

// What is found of each limit, once where two find the same.
std::string measured_in_words(const GateOutcome& outcome) {
  if (!outcome.measured) return shown_text(outcome.advice());
  std::string text, last;
  for (const Criterion& criterion : outcome.measured->criteria) {
    std::string finding = finding_of(outcome, criterion);
    if (finding != last) text = joined(text, finding, "; ");
    last = std::move(finding);
  }
  return text;
}

}  // namespace

std::string shown_name(std::string_view bytes) {
  std::string name = visible(bytes, false);
  const bool blank = std::all_of(name.begin(), name.end(), [](char c) { return c == ' '; });
  return blank ? "(unnamed)" : name;
}

std::string shown_text(std::string_view bytes) { return visible(bytes, true); }

std::string cut_at(std::string text, std::size_t bytes) {
  if (text.size() <= bytes) return text;
  while (bytes > 0 && is_within_character(text[bytes])) --bytes;
  return text.substr(0, bytes) + "...";
}

std::string limit_of(const GateOutcome& outcome) {
  if (outcome.measured) return limit_in_words(outcome, outcome.measured->foremost());
  std::string text;
  for (const Criterion& asked : api::limits_asked(outcome.gate.request.options)) {
    if (asked.is_of_region()) continue;
    const std::string share = asked.beyond ? to_digits(100 * asked.limit, kDigits) + " % beyond " : "";
    text = joined(text, share + length_in_words(outcome, asked.beyond.value_or(asked.limit)) + side_of(asked), ", ");
  }
  return text;
}

std::string interval_of(const GateOutcome& outcome) {
  if (!outcome.measured) return "";
  const Criterion& foremost = outcome.measured->foremost();
  return (foremost.region.empty() ? "" : shown_name(foremost.region) + ": ") +
         interval_in_words(foremost, outcome.unit());
}

std::string interval_in_words(const Criterion& criterion, const std::string& unit) {
  const IntervalText figures = figures_of(criterion);
  const std::string shown_unit = criterion.beyond ? "%" : unit, side = side_of(criterion);
  if (criterion.verdict == api::Verdict::fail && criterion.upper - criterion.lower > criterion.lower)
    return "at least " + with_unit(figures.lower, shown_unit) + side;
  if (!criterion.refused.empty()) return "no sides";
  return with_unit(figures.lower + " .. " + figures.upper, shown_unit) + side;
}

std::string share_of_diagonal(const GateOutcome& outcome, const Criterion& criterion) {
  return is_of_diagonal(outcome.gate) ? in_percent_of_diagonal(asked_for(outcome.gate, criterion)) : "";
}

std::vector<CriterionWords> criteria_in_words(const GateOutcome& outcome) {
  std::vector<CriterionWords> all;
  if (!outcome.measured) return all;
  for (const Criterion& c : outcome.measured->criteria)
    all.push_back({shown_name(c.name), interval_in_words(c, outcome.unit()), limit_in_words(outcome, c), c});
  return all;
}

std::string unmet_of(const GateOutcome& outcome) {
  std::string text;
  for (const Criterion& one : outcome.expectations) {
    if (one.verdict == api::Verdict::pass) continue;
    text = joined(text, api::finding_of(one, ""), "; ");
  }
  return text;
}

std::string finding_of(const GateOutcome& outcome) {
  const std::string unmet = unmet_of(outcome);
  if (unmet.empty()) return measured_in_words(outcome);
  return outcome.measured->verdict == Verdict::pass ? unmet + "; " + measured_in_words(outcome)
                                                    : measured_in_words(outcome) + "; " + unmet;
}

std::string witness_of(const GateOutcome& outcome) {
  if (!outcome.measured || !outcome.measured->witness || outcome.verdict() == Verdict::fail) return "";
  const Witness& witness = *outcome.measured->witness;
  return with_unit(api::in_words(witness.from), outcome.unit()) + " on " + outcome.measured->place_of_witness() +
         " of the " + witness.from_mesh() + "; nearest is " + with_unit(api::in_words(witness.to), outcome.unit()) +
         " on triangle " + std::to_string(witness.to_triangle) + " of the " + witness.to_mesh();
}

std::vector<std::string> unmeasured_of(const GateOutcome& outcome) {
  std::vector<std::string> notes;
  if (outcome.measured)
    for (const std::string& note : outcome.measured->unread) notes.push_back(shown_name(note));
  for (const std::string& note : outcome.gate.notes) notes.push_back(shown_name(note));
  return notes;
}

std::vector<std::string> notes_of(const GateOutcome& outcome) {
  std::vector<std::string> notes = unmeasured_of(outcome);
  if (!outcome.measured) return notes;
  for (const std::string& note : outcome.measured->notes) notes.push_back(shown_name(note));
  return notes;
}

std::string advice_of(const GateOutcome& outcome) { return outcome.measured ? shown_text(outcome.advice()) : ""; }

std::string source_of(const Gate& gate) {
  if (gate.manifest.empty()) return "";
  return shown_name(gate.manifest) + (gate.line > 0 ? ":" + std::to_string(gate.line) : "");
}

}  // namespace meshgauge::check
