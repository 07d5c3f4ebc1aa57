// Wording that reports share: names of files, numbers, and sentences about an outcome.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "check/outcome.h"
#include "check/text.h"

namespace meshgauge::check {

// Returns a file's name, which may be any bytes, as one line of UTF-8. Line ends, control characters, marks that
// change the direction of writing and bytes that are not UTF-8 become escapes:
// , \x1B, \u202E. The result is valid in XML 1.0 and JSON. "(unnamed)" if there are only blanks.
std::string shown_name(std::string_view bytes);
std::string shown_text(
    std::string_view bytes);  // the same for sentences: line ends and tabs stay, and an empty text stays empty

// Cuts text between characters of UTF-8, with "..." in the place of what is left out.
std::string cut_at(std::string text, std::size_t bytes);

using api::figures_of;

// Returns the limit of the foremost criterion; without a measurement the limits as the gate says them.
std::string limit_of(const GateOutcome& outcome);  // "0.05 mm", "0.0173 (0.5 % of the baseline's diagonal)"
// Returns "0.0968 .. 0.0977 mm" of the foremost criterion, "bore: 0.0968 .. 0.0977 mm" of a region; "at least 0.0968
// mm" for a fail whose upper bound says little, because it is more than twice the lower one; empty without an interval.
std::string interval_of(const GateOutcome& outcome);
// Returns the same of any limit, without the name of its region. `unit`: of lengths; may be empty.
std::string interval_in_words(const Criterion& criterion, const std::string& unit);
// Returns the share of the diagonal that the limit of a distance is as the gate says it, "0.5 %"; empty: it is none.
std::string share_of_diagonal(const GateOutcome& outcome, const Criterion& criterion);
// A line of a report for a limit: its name, interval and limit as interval_of() and limit_of() say them.
struct CriterionWords {
  std::string name, interval, limit;
  Criterion criterion;
};
std::vector<CriterionWords> criteria_in_words(const GateOutcome& outcome);  // of all limits; empty: not measured
// Returns the finding: "the distance is at least 0.0968 mm, above the limit of 0.05 mm". Without a measurement: the
// advice.
std::string finding_of(const GateOutcome& outcome);
// Returns the expectations that are not met, or not decided: "triangles: 24512, expected at most 20000; ...". Empty:
// none.
std::string unmet_of(const GateOutcome& outcome);
std::string advice_of(const GateOutcome& outcome);  // empty if finding_of() says it
// Notes, one sentence each without full stop: what was not measured, what was converted, what looks like a wrong unit.
std::vector<std::string> notes_of(const GateOutcome& outcome);
// Those of them that say what was not measured: surface that was not read, files that a glob passes over. A report
// shows them also where the gate passes.
std::vector<std::string> unmeasured_of(const GateOutcome& outcome);
// Returns "(1, 2, 3) on triangle 7 of the candidate; nearest is ...". Empty without a witness, and for a fail, whose
// advice names it.
std::string witness_of(const GateOutcome& outcome);
std::string source_of(const Gate& gate);  // "gates.yaml:7"; empty when flags gave it

}  // namespace meshgauge::check
