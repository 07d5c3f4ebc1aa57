// Results of gates: everything that reports show. `document` is the same JSON whether this process or a service
// measured.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/gate.h"
#include "api/region_json.h"
#include "api/result_document.h"
#include "check/gate.h"
#include "engine/result.h"

namespace meshgauge::check {

// pass, fail, undecided: the interval against the limit (api/gate.h), or an expectation. error: there is no interval,
// because a file is missing or unreadable or the service cannot be reached.
enum class Verdict { pass, fail, undecided, error };
std::string_view to_string(Verdict verdict);
Verdict verdict_of(api::Verdict verdict);
// As api::verdict_within().
Verdict verdict_of(double lower, double upper, double limit, double uncertainty = 0);

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

// The largest share of the area, in any direction that was measured, that is farther than max_share_beyond's distance.
struct ShareBeyond {
  api::ShareLimit limit;  // of the request
  double lower = 0;       // from 0 to 1
  double upper = 1;
  std::string status;  // why its narrowing ended: "complete", "timeout", ...
};

// How far the candidate reaches on both sides of the baseline; lengths in the unit of the result.
struct ZoneReached {
  struct Side {
    double limit = 0;  // of the request
    double lower = 0;
    double upper = std::numeric_limits<double>::infinity();
    std::optional<Vec3> at;      // a point of the candidate that is `lower` or more on that side
    std::uint32_t triangle = 0;  // that holds it
  };
  Side inside, outside;
  std::string refused;  // why the baseline has no sides; empty: it has
  std::string status;   // why the work ended
};

// One limit of a gate, and the interval of what it limits.
struct Criterion {
  std::optional<double> beyond;  // the limit is of the area that is farther than this; nullopt: of the distance
  double uncertainty = 0;        // of the distance, or of `beyond`; in the unit of the result
  double limit = 0;              // in the unit of the result; of the area in percent, as the following
  double lower = 0;
  double upper = 0;
  std::string status;  // why the work on it ended
  Verdict verdict = Verdict::undecided;
  std::string region{};     // of the gate; "rest": what is in none of its regions; empty: of the whole surface
  std::string_view side{};  // "inside", "outside": of the distance on that side of the baseline; empty: of all

  bool is_of_region() const { return !region.empty() && region != api::kRest; }
  // "distance", "distance in bore", "distance in no region", "distance inside".
  std::string distance_name() const;
};

// A measurement, as check reads it from the JSON of a comparison (openapi.yaml, "Comparison").
struct Measured {
  nlohmann::ordered_json document;  // JSON of the whole comparison
  double limit = 0;                 // max_distance of the request; 0: none
  api::DistanceLimit shown{};       // as in api::ResultFacts
  bool has_max_distance = true;
  double uncertainty = 0;  // of the request
  std::optional<ShareBeyond> share_beyond;
  std::vector<Criterion> regions;  // of the gate; then what follows is of the rest
  std::optional<ZoneReached> zone;
  double lower = 0;
  double upper = 0;
  api::UnitPlan units;                   // units of the meshes as read, and of every length here
  std::optional<RigidMotion> motion;     // of the candidate before it was measured; nullopt: none
  std::vector<std::string> notes;        // one sentence each: what was converted, what looks like a wrong unit
  std::vector<std::string> unread{};     // notes on what was not read of a surface, and so not measured
  std::string status;                    // "converged", "gate_decided", "timeout", ...
  Verdict verdict = Verdict::undecided;  // of all limits
  // Belongs to the direction that attains `lower`; to the region that fails, unless the rest does. nullopt: none.
  std::optional<Witness> witness;
  std::optional<double> reached{};  // the lower bound that a witness of a region attains; nullopt: `lower`
  std::optional<api::ResultDirection> direction;  // from the candidate to the baseline; nullopt: not measured
  // URL of the page that shows the comparison while the service keeps it: ASCII, safe inside a link of any report.
  // Empty: measured in this process, or by a service without pages.
  std::string link;

  // "triangle 17", or "point 17" of a point cloud: where the witness lies on the mesh measured from. Empty: no witness.
  std::string place_of_witness() const;
};

// Extracts the fields from a comparison's JSON. Errors: internal if it is not a comparison or has no valid interval.
Result<Measured> measured_from(nlohmann::ordered_json document, const Limits& limits);

// Returns why the result does not count; nullopt: it does. A mesh file that was cut before its faces looks like a point
// cloud, so a candidate without triangles must be declared by Gate::cloud, unless its format holds clouds alone.
std::optional<Error> undeclared_cloud(const Gate& gate, const nlohmann::ordered_json& document);

// Returns the limits of the gate: of the distance, inside, outside, of the distance in each region, of the area. At
// least one. A baseline without sides has the limit outside alone, and nothing is known of it.
std::vector<Criterion> criteria_of(const Measured& measured);

// Returns the one to show where there is room for one: it has the verdict of the gate, and comes nearest to its limit.
Criterion foremost(const Measured& measured);

api::ResultFacts facts_of(const Measured& measured);

// One of several limits in one run: of a side of a zone, or of a region.
struct PastLimit {
  std::optional<double> lower, upper;  // nullopt: the baseline has no sides, or no finite upper bound
  double limit = 0;
};

// The result of a gate in one run; lengths in `unit`.
struct PastRun {
  std::string commit;  // empty: not known
  Verdict verdict = Verdict::undecided;
  std::optional<double> lower, upper, limit;     // nullopt: not measured, or no finite upper bound
  std::string unit;                              // empty: not known
  std::optional<ShareBeyond> share_beyond{};     // without its status; nullopt: no such limit, or not measured
  std::optional<PastLimit> inside{}, outside{};  // nullopt: no zone, or not measured
  double uncertainty = 0;                        // of the lengths
  std::map<std::string, PastLimit> regions{};    // by name, without the rest, which has `lower`, `upper` and `limit`
};

struct GateOutcome {
  Gate gate;
  std::optional<Measured> measured;  // nullopt: see `error`
  std::vector<Expectation> expectations;
  std::optional<Error> error;    // with `interrupted`: the time was over; nullopt after Ctrl-C
  bool interrupted = false;      // by Ctrl-C or the timeout, before there was an interval; the verdict is undecided
  double wall_ms = 0;            // includes reading and waiting
  std::vector<PastRun> history;  // of the last runs, this one at the end; empty without --history

  Verdict verdict() const;  // the worst of the distance and the expectations
  // Unit of every length of this outcome, such as "mm"; empty: not known.
  std::string unit() const;
  Level level(Undecided rule) const;
  // What to do, in one or two sentences: for undecided, which timeout or limit would decide; for fail, where to look;
  // for error, what to repair. Empty for pass.
  std::string advice() const;
};

struct Report {
  std::vector<GateOutcome> outcomes;  // in the order of the gates
  Undecided undecided = Undecided::separate;
  bool interrupted = false;  // by Ctrl-C
  std::string version;       // of meshgauge
  // URLs of the pages of batches that a service measured, in the form of Measured::link. May be empty.
  std::vector<std::string> batches;

  std::size_t count(Verdict verdict) const;
  // 0 pass, 1 fail, 2 undecided, 3 error: the worst of all gates, in the order 3, 1, 2, 0.
  int exit_code() const;
};

}  // namespace meshgauge::check
