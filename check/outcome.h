// What became of the gates. Everything that reports show is here, whoever measured: `document` is what the service
// answers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/gate.h"
#include "api/result_document.h"
#include "check/gate.h"
#include "engine/result.h"

namespace meshgauge::check {

// pass, fail, undecided: what the interval says about the limit (api/gate.h). error: there is no interval: a file that
// is missing or cannot be read, a service that cannot be reached.
enum class Verdict { pass, fail, undecided, error };
std::string_view to_string(Verdict verdict);

// What of it counts: `level` of a failed gate is `warning` when the gate only warns. Errors always count, and so does
// an undecided gate of which nothing is known, since its time was over while a file was read.
enum class Level { ok, warning, failure };
std::string_view to_string(Level level);

enum class Undecided { separate, fail, warn };  // --undecided: exit code 2 of its own, or counted as the others are

using Witness = api::ResultWitness;

// A measurement, as check reads it from the JSON of a comparison (openapi.yaml, "Comparison").
struct Measured {
  nlohmann::ordered_json document;  // the whole comparison
  double limit = 0;                 // max_distance that was asked for
  double lower = 0;
  double upper = 0;
  api::UnitPlan units;             // of the meshes as read, and of every length here
  std::vector<std::string> notes;  // of the pair, one sentence each: what was converted, what looks like a wrong unit
  std::string status;              // "converged", "gate_decided", "timeout", ...
  Verdict verdict = Verdict::undecided;
  std::optional<Witness> witness;                 // of the direction that attains `lower`
  std::optional<api::ResultDirection> direction;  // from the candidate to the baseline; none: not measured
  // Where a browser sees it for as long as the service that measured it keeps it: ASCII, without what ends a link in
  // any report. Empty: measured in this process, or by a service without a page.
  std::string link;
};

// The fields of a comparison's JSON; internal when it is none, or its interval none.
Result<Measured> measured_from(nlohmann::ordered_json document, double limit);

struct GateOutcome {
  Gate gate;
  std::optional<Measured> measured;  // none: `error` says why
  std::optional<Error> error;        // with `interrupted`: that the time was over; none after Ctrl-C
  bool interrupted = false;          // by Ctrl-C or its timeout, before there was an interval: undecided
  double wall_ms = 0;                // reading and waiting included

  Verdict verdict() const;
  // Of every length of this outcome, "mm"; empty: not known.
  std::string unit() const;
  Level level(Undecided rule) const;
  // What to do, in one or two sentences: for undecided which timeout or limit would decide it, for fail where to look,
  // for error what to repair. Empty for pass.
  std::string advice() const;
};

struct Report {
  std::vector<GateOutcome> outcomes;  // in the order of the gates
  Undecided undecided = Undecided::separate;
  bool interrupted = false;  // by Ctrl-C
  std::string version;       // of meshgauge
  // Of the pages on which a browser sees gates that a service has measured together, as Measured::link. May be empty.
  std::vector<std::string> batches;

  std::size_t count(Verdict verdict) const;
  // 0 pass, 1 fail, 2 undecided, 3 error; the worst of all gates in the order 3, 1, 2, 0.
  int exit_code() const;
};

}  // namespace meshgauge::check
