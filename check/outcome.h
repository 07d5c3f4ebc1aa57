// Results of gates: everything that reports show. `document` is the same JSON whether this process or a service
// measured.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/compare/prepared_mesh.h"
#include "api/options/names.h"
#include "api/result/criteria.h"
#include "api/result/result_document.h"
#include "api/result/verdict.h"
#include "check/gate.h"
#include "check/manifest/mistake.h"
#include "engine/options.h"
#include "engine/result.h"

namespace meshgauge::check {

// pass, fail, undecided: the interval against the limit (api/result/verdict.h), or an expectation. error: there is no
// interval, because a file is missing or unreadable or the service cannot be reached.
enum class Verdict { pass, fail, undecided, error };
inline constexpr api::Name<Verdict> kVerdicts[] = {
    {Verdict::pass, "pass"}, {Verdict::fail, "fail"}, {Verdict::undecided, "undecided"}, {Verdict::error, "error"}};
std::string_view to_string(Verdict verdict);
Verdict verdict_of(api::Verdict verdict);

// How an outcome counts. `warning`: a fail or an undecided gate with warn_only, or an undecided one with
// --undecided=warn. `failure`: every other outcome that is not a pass, every error, and an undecided gate of which a
// limit or an expectation is not known at all.
enum class Level { ok, warning, failure };
std::string_view to_string(Level level);

enum class Undecided {
  separate,
  fail,
  warn
};  // --undecided: exit code 2 of its own, counted as a fail, or as a warning

using Witness = api::ResultWitness;

using api::Criterion;

// A measurement, as check reads it from the JSON of a comparison (openapi.yaml, "Comparison"). Its facts are those of
// the candidate; the distance is that of the rest where there are regions. `witness`: of the direction that attains
// `lower`; unless the gate passes, of api::foremost_place().
struct Measured : api::ResultFacts {
  nlohmann::ordered_json document;       // JSON of the whole comparison
  std::vector<Criterion> criteria;       // the limits of the gate, in the order of api::criteria_of(); at least one
  std::vector<std::string> notes;        // one sentence each: what was converted, what looks like a wrong unit
  std::vector<std::string> unread{};     // notes on what was not read of a surface, and so not measured
  std::string status;                    // "converged", "gate_decided", "timeout", ...
  Verdict verdict = Verdict::undecided;  // of all limits
  double reached = 0;                    // the lower bound that the witness attains
  // URL of the page that shows the comparison while the service keeps it: ASCII, safe inside a link of any report.
  // Empty: measured in this process, or by a service without pages.
  std::string link;

  const Criterion& foremost() const { return api::foremost(criteria); }
  // Returns the limit of the distance, of the rest where there are regions; null: the gate has none.
  const Criterion* distance() const;
  // The limit that distances without a sign are shown against.
  api::DistanceLimit shown() const { return limit.value_or(api::DistanceLimit{}); }
  // "triangle 17", or "point 17" of a point cloud: where the witness lies on the mesh measured from. Empty: no witness.
  std::string place_of_witness() const;
};

// Extracts the fields from a comparison's JSON. Verdicts are those of the intervals, whatever the JSON says. Errors:
// internal if it is not a comparison, has no valid interval, or has other criteria than the gate asks for.
Result<Measured> measured_from(nlohmann::ordered_json document, const Gate& gate);

// Returns why the result does not count; nullopt: it does. A mesh file that was cut before its faces looks like a point
// cloud, so a candidate without triangles must be declared by Gate::cloud, unless its format holds clouds alone.
std::optional<Error> undeclared_cloud(const Gate& gate, const nlohmann::ordered_json& document);
// The same, before anything is measured. `candidate`: its facts.
std::optional<Error> undeclared_cloud(const Gate& gate, const api::MeshFacts& candidate);

// A criterion in one run; a share is from 0 to 1.
struct PastCriterion {
  std::optional<double> lower, upper;  // nullopt: the baseline has no sides, or no finite upper bound
  double limit = 0;
};

// The result of a gate in one run; lengths in `unit`.
struct PastRun {
  std::string commit;  // empty: not known
  Verdict verdict = Verdict::undecided;
  std::optional<double> lower, upper, limit;  // nullopt: not measured, or no finite upper bound
  std::string unit;                           // empty: not known
  api::LimitTerms terms{};
  std::map<std::string, PastCriterion> criteria{};  // the limits, by name

  LimitEnds ends() const { return terms.ends(limit.value_or(0)); }
};

struct GateOutcome {
  Gate gate;
  std::optional<Measured> measured;  // nullopt: see `error`
  std::vector<Criterion> expectations;
  std::optional<Error> error;    // with `interrupted`: the time was over; nullopt after Ctrl-C
  bool interrupted = false;      // by Ctrl-C or the timeout, before there was an interval; the verdict is undecided
  double wall_ms = 0;            // includes reading and waiting
  std::vector<PastRun> history;  // of the last runs, this one at the end; empty without --history

  Verdict verdict() const;  // the worst of the distance and the expectations
  // The limits, then the expectations; none without a measurement.
  std::vector<Criterion> criteria() const;
  // Unit of every length of this outcome, such as "mm"; empty: not known.
  std::string unit() const;
  Level level(Undecided rule) const;
  // What to do, in one or two sentences: for undecided, which timeout or limit would decide; for fail, where to look;
  // for error, what to repair. Empty for pass.
  std::string advice() const;
};

// A gate in an earlier run; its limits, none without a measurement, and the unit of lengths, empty where not known.
struct EarlierGate {
  Verdict verdict = Verdict::undecided;
  std::string unit{};
  std::vector<Criterion> criteria{};
};

// An earlier run, by its report (check --since).
struct Earlier {
  std::string name;                                         // of the report's file, without suffix
  std::map<std::string, EarlierGate, std::less<>> gates{};  // by name
  std::string problem{};                                    // why the report cannot be read; empty: it can
};

// A git revision: as it is asked for, and the digest of its commit.
struct RevisionName {
  std::string ref;
  std::string commit;

  std::string in_words() const { return ref + " (" + commit.substr(0, 12) + ")"; }
};

struct Report {
  std::vector<GateOutcome> outcomes;  // in the order of the gates
  Undecided undecided = Undecided::separate;
  bool interrupted = false;  // by Ctrl-C
  std::string version;       // of meshgauge
  // URLs of the pages of batches that a service measured, in the form of Measured::link. May be empty.
  std::vector<std::string> batches;
  std::optional<Earlier> since{};         // what reports tell changes from
  std::optional<RevisionName> against{};  // whose baselines they are; nullopt: those of the work tree

  std::size_t count(Verdict verdict) const;
  // 0 pass, 1 fail, 2 undecided, 3 error: the worst of all gates, in the order 3, 1, 2, 0.
  int exit_code() const;
};

// Returns the report of a run that did not begin: one outcome for each mistake, an error, named by its place
// ("gates.yaml:7:5"), without meshes. It is written so that the reports show the mistakes and no older report is taken
// for this run's. `manifest`: empty if the mistakes are not in a manifest.
Report mistaken(const std::string& manifest, const std::vector<Mistake>& mistakes);

}  // namespace meshgauge::check
