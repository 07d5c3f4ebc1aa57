// The words that reports share: names of files, numbers and what a gate's outcome says, for people.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "check/outcome.h"

namespace meshgauge::check {

// The name of a file is any bytes. On one line, in UTF-8 and as it is read: line ends, control characters, marks that
// turn the direction of reading, and bytes that are not UTF-8 are written as escapes: \n, \x1B, \u202E. What is left
// may stand in XML 1.0 and JSON. "(unnamed)" for nothing but blanks.
std::string shown_name(std::string_view bytes);
std::string shown_text(std::string_view bytes);  // the same for sentences: line ends and tabs stay, and so does nothing

std::string limit_of(const GateOutcome& outcome);     // "0.05 mm", "0.0173 (0.5 % of the baseline's diagonal)"
std::string interval_of(const GateOutcome& outcome);  // "0.0968 .. 0.0977 mm"; empty without one
// What was found: "the distance is at least 0.0968 mm, above the limit of 0.05 mm". Without a measurement the advice.
std::string finding_of(const GateOutcome& outcome);
std::string advice_of(const GateOutcome& outcome);  // empty where finding_of() says it
// Of the pair, one sentence each without its full stop: what was converted, what looks like a wrong unit.
std::vector<std::string> notes_of(const GateOutcome& outcome);
// "(1, 2, 3) on triangle 7 of the candidate; nearest is ..."; empty without one, and for a fail: its advice names it.
std::string witness_of(const GateOutcome& outcome);
std::string source_of(const Gate& gate);  // "gates.yaml:7"; empty when flags gave it

}  // namespace meshgauge::check
