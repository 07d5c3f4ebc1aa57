// Reports for the tests of what writes them: one of each kind, and names that a pipeline would rather not meet.
#pragma once

#include <string>
#include <vector>

#include "check/outcome.h"

namespace meshgauge::check::samples {

GateOutcome passed(const std::string& name);
GateOutcome failed(const std::string& name);
GateOutcome undecided(const std::string& name);
GateOutcome broken(const std::string& name);  // an error
// At most 1 % of the area may be farther than 0.05 mm; from 0.2012 to 0.2699 % are, and `more`, a share of 1.
GateOutcome area(const std::string& name, double more = 0);
// A zone of 0.05 mm inside and 0.1 mm outside; the candidate reaches 0.06 to 0.07 mm inside, 0.01 to 0.02 mm outside.
GateOutcome zone(const std::string& name);

Report report_of(std::vector<GateOutcome> outcomes);

// Names that hold what XML, JSON, Markdown, HTML or a forge gives a meaning, or forbids.
std::vector<std::string> hostile_names();
Report hostile();   // each of them as a name, as files, as units and in an error's message; every verdict
Report ordinary();  // a pass, a fail, an undecided, an error, and a fail that only warns

struct Named {
  const char* name;
  Report report;
};
std::vector<Named> all();  // also: none at all, all passed, interrupted, undecided allowed

}  // namespace meshgauge::check::samples
