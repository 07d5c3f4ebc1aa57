#include "check/reports/wording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "api/with_unit.h"
#include "check/html/figures.h"
#include "check/utf8.h"

namespace meshgauge::check {
namespace {

using api::with_unit;

constexpr int kDigits = 6;  // of a coordinate

std::string escape(const char* format, std::uint32_t value) {
  std::array<char, 16> text{};
  const int n = std::snprintf(text.data(), text.size(), format, value);
  return {text.data(), static_cast<std::size_t>(n)};
}

// Whether a character is invisible or forbidden in XML 1.0: controls, line separators, marks of direction,
// noncharacters.
bool is_hidden(std::uint32_t c) {
  if (c < 0x20 || (c >= 0x7F && c < 0xA0)) return true;
  if ((c >= 0x200B && c <= 0x200F) || (c >= 0x2028 && c <= 0x202E) || (c >= 0x2060 && c <= 0x206F)) return true;
  return c == 0x061C || c == 0xFEFF || (c & 0xFFFE) == 0xFFFE || (c >= 0xFDD0 && c <= 0xFDEF);
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

IntervalText figures_of(const Measured& measured) { return to_text(measured.lower, measured.upper, measured.limit); }

std::string point(const Vec3& p) {
  return "(" + to_digits(p.x(), kDigits) + ", " + to_digits(p.y(), kDigits) + ", " + to_digits(p.z(), kDigits) + ")";
}

std::string limit_in_words(const GateOutcome& outcome, const std::string& number) {
  const Gate& gate = outcome.gate;
  if (!gate.limit.max_diagonal_share) return with_unit(number, outcome.unit());
  return with_unit(number, outcome.unit()) + " (" + to_digits(100 * *gate.limit.max_diagonal_share, kDigits) +
         " % of the baseline's diagonal)";
}

std::string distance_in_words(const GateOutcome& outcome) {
  if (!outcome.measured) return shown_text(outcome.advice());
  const IntervalText figures = figures_of(*outcome.measured);
  const std::string limit = limit_in_words(outcome, figures.limit);
  const std::string range = std::isfinite(outcome.measured->upper)
                                ? "between " + figures.lower + " and " + with_unit(figures.upper, outcome.unit())
                                : "at least " + with_unit(figures.lower, outcome.unit());
  switch (outcome.measured->verdict) {
    case Verdict::pass:
      return "the distance is at most " + with_unit(figures.upper, outcome.unit()) + ", within the limit of " + limit;
    case Verdict::fail:
      return "the distance is at least " + with_unit(figures.lower, outcome.unit()) + ", above the limit of " + limit;
    default:
      return "the distance is " + range + ": whether that is within the limit of " + limit + " is not known (" +
             shown_name(outcome.measured->status) + ")";
  }
}

}  // namespace

std::string shown_name(std::string_view bytes) {
  std::string name = visible(bytes, false);
  const bool blank = std::all_of(name.begin(), name.end(), [](char c) { return c == ' '; });
  return blank ? "(unnamed)" : name;
}

std::string shown_text(std::string_view bytes) { return visible(bytes, true); }

std::string limit_of(const GateOutcome& outcome) {
  if (outcome.measured) return limit_in_words(outcome, figures_of(*outcome.measured).limit);
  const Limit& limit = outcome.gate.limit;
  if (limit.max_distance) return with_unit(to_digits(*limit.max_distance, kDigits), outcome.unit());
  if (!limit.max_diagonal_share) return "";
  return to_digits(100 * *limit.max_diagonal_share, kDigits) + " % of the baseline's diagonal";
}

std::string interval_of(const GateOutcome& outcome) {
  if (!outcome.measured) return "";
  const Measured& measured = *outcome.measured;
  const IntervalText figures = figures_of(measured);
  if (measured.verdict == Verdict::fail && measured.upper - measured.lower > measured.lower)
    return "at least " + with_unit(figures.lower, outcome.unit());
  return with_unit(figures.lower + " .. " + figures.upper, outcome.unit());
}

std::string unmet_of(const GateOutcome& outcome) {
  std::string text;
  for (const Expectation& one : outcome.expectations) {
    if (one.verdict == Verdict::pass) continue;
    text += (text.empty() ? "" : "; ") + one.name + ": " + one.found + ", expected " + one.expected;
  }
  return text;
}

std::string finding_of(const GateOutcome& outcome) {
  const std::string unmet = unmet_of(outcome);
  if (unmet.empty()) return distance_in_words(outcome);
  return outcome.measured->verdict == Verdict::pass ? unmet + "; " + distance_in_words(outcome)
                                                    : distance_in_words(outcome) + "; " + unmet;
}

std::string witness_of(const GateOutcome& outcome) {
  if (!outcome.measured || !outcome.measured->witness || outcome.verdict() == Verdict::fail) return "";
  const Witness& witness = *outcome.measured->witness;
  const std::string from = witness.on_candidate ? "candidate" : "baseline";
  const std::string to = witness.on_candidate ? "baseline" : "candidate";
  return with_unit(point(witness.from), outcome.unit()) + " on triangle " + std::to_string(witness.from_triangle) +
         " of the " + from + "; nearest is " + with_unit(point(witness.to), outcome.unit()) + " on triangle " +
         std::to_string(witness.to_triangle) + " of the " + to;
}

std::vector<std::string> notes_of(const GateOutcome& outcome) {
  std::vector<std::string> notes;
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
