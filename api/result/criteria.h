// The criteria of a comparison: each limit of its gate and each expectation, what was found of it, and its verdict.
// Made once; results, reports and pages show this list.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/base/figures.h"
#include "api/compare/compare.h"
#include "api/result/verdict.h"
#include "engine/options.h"
#include "engine/result.h"

namespace meshgauge::api {

// What a gate says once, of all its limits.
struct LimitTerms {
  double uncertainty = 0;  // of the distance, or of the distance that a share is beyond

  bool is_uncertain() const { return uncertainty > 0; }
  LimitEnds ends(double limit) const { return ends_of(limit, uncertainty); }
};

struct Criterion : LimitTerms {
  enum class Of { distance, share, expectation };

  // A point that is at least `lower` from the other mesh.
  struct Place {
    bool on_a = true;
    Vec3 point = Vec3::Zero();
    std::uint32_t triangle = 0;          // 0-based, as read; of a cloud the point's index
    std::optional<Vec3> nearest;         // on the other mesh; nullopt: not known
    std::uint32_t nearest_triangle = 0;  // that holds `nearest`
  };

  Of of = Of::distance;
  std::string name;  // unique: "distance", "distance in bore", "distance outside", "share beyond", "watertight"
  Verdict verdict = Verdict::undecided;

  // A limit, of a distance or a share. Lengths are in the unit of the result; limit and bounds of a share are from 0
  // to 1.
  std::string region{};            // of the request, or kRest; empty: without regions
  std::string side{};              // "inside", "outside": how far mesh a reaches there; empty: of no side
  std::optional<double> beyond{};  // the share is of the area that is farther than this
  double limit = 0;
  double lower = 0;  // certified
  double upper = std::numeric_limits<double>::infinity();
  std::string status{};       // why the work on it ended: "converged", "timeout", "complete", ...
  std::optional<Place> at{};  // nullopt: none is known, or of a share
  std::string refused{};      // why mesh b has no sides: "mesh b is open: ..."; empty: it has

  // An expectation, in words: "at most 20000", "24512".
  std::string expected{}, found{};
  bool in_time{true};  // false: the time ended before anything was found

  bool is_of_region() const;  // not of the rest
  bool is_of_whole() const;   // a limit of the distance that is of no region and of no side
  bool is_known() const;      // whether anything is known of it

  // What the uncertainty adds to the bounds: none to those of a share, whose distance has it.
  double margin() const { return of == Of::share ? 0 : uncertainty; }
  LimitEnds ends() const { return ends_of(limit, margin()); }
};

// A limit that distances without a sign are shown against.
struct DistanceLimit {
  double limit = 0;
  std::string side{};  // "inside", "outside"; empty: both
};

// Returns the limits: of the distance, or of the rest where there are regions; inside; outside; of each region; of the
// area. Empty: without a gate.
// `unit`: of the lengths, for the words of `refused`.
std::vector<Criterion> criteria_of(const Outcome& outcome, const ComparisonOptions& options,
                                   const std::optional<LengthUnit>& unit = {});
// Returns the same limits, of which nothing is known.
std::vector<Criterion> limits_asked(const ComparisonOptions& options);

// Returns the limits, and behind them the expectations.
std::vector<Criterion> criteria_of(const Comparison& comparison);
// `expectations`: expectations_of(comparison).
std::vector<Criterion> criteria_of(const Comparison& comparison, const std::vector<Criterion>& expectations);

// Returns the limit to show. Of those of the distance with the worst verdict, without those of regions, it is
//   1. the first that is of both sides;
//   2. else the smallest, or the largest where all pass.
// Where the distance has no limit but a share beyond it has: that distance. nullopt: there is none of these.
std::optional<DistanceLimit> shown_limit(std::span<const Criterion> criteria);

// Returns the worst verdict; nullopt: there is no criterion.
std::optional<Verdict> worst(std::span<const Criterion> criteria);

// Returns the one to show where there is room for one: of those with the worst verdict the limit that is exceeded
// most, or is nearest to being exceeded, in shares of the limit; an expectation where it alone has that verdict.
// Precondition: there is a criterion.
const Criterion& foremost(std::span<const Criterion> criteria);

// Returns them with that one at the front; the others keep their order.
std::vector<Criterion> foremost_first(std::vector<Criterion> criteria);

// Returns the one to look at: of those with the worst verdict and a place the one that comes first as by foremost();
// null: none has a place.
const Criterion* foremost_place(std::span<const Criterion> criteria);

// Returns the verdict of a limit from its own numbers; undecided where mesh b has no sides.
Verdict verdict_of(const Criterion& limit);

// Returns the limit with its name and its verdict, which follow from the rest.
Criterion judged(Criterion limit);

// Whether both limit the same, by the same: all but what was found.
bool is_same_limit(const Criterion& one, const Criterion& other);

// Returns bounds and limit as texts, each number on its side of the limit; with an uncertainty, of what it leaves of
// pass and of fail. Of a share in percent. Precondition: no expectation.
IntervalText figures_of(const Criterion& criterion);

// Returns " ± 0.01 mm", what stands behind the limit; empty without an uncertainty.
inline std::string plus_minus(const LimitTerms& terms, std::string_view unit) {
  return plus_minus(terms.uncertainty, unit);
}

// Returns "the distance in bore is at least 0.0312 mm, above the limit of 0.02 mm", without full stop. `unit`: of the
// lengths, may be empty. `limit`: the limit of a distance in other words, such as "0.1 mm (0.5 % of the diagonal)";
// empty: as above.
std::string finding_of(const Criterion& criterion, std::string_view unit, const std::string& limit = {});

// Returns why no narrower interval decides the limit: "the limit is within rounding error of the distance" or the like.
std::string why_open(const Criterion& limit);

// Returns "between 0.2 and 0.27 % of the area is farther than 0.05 mm". Precondition: the criterion is a share.
std::string share_in_words(const Criterion& share, std::string_view unit);

// Returns the share with limit and bounds in percent, the bounds not nearer to each other than they are.
Criterion in_percent(Criterion share);

// Writes the terms as documents have them beside limits, {"uncertainty": 0.01}; {} without an uncertainty.
nlohmann::ordered_json terms_json(const LimitTerms& terms);

// Reads them from among the members of an object; one that is missing or no number is 0.
LimitTerms terms_in(const nlohmann::ordered_json& object);

// Writes a criterion of a result document (openapi.yaml, "Criterion"); an infinite bound as null.
nlohmann::ordered_json json_of(const Criterion& criterion, std::string_view unit);

// Reads what json_of() writes. Name and verdict of a limit are as by judged(), whatever the document says. Error:
// internal when it is no criterion or has no interval.
Result<Criterion> read_criterion(const nlohmann::ordered_json& json);

// Reads the criteria of a result document; what is no criterion is left out. Results of before 0.2.0 have none.
std::vector<Criterion> read_criteria(const nlohmann::ordered_json& document);

}  // namespace meshgauge::api
