// Criteria and measurements for the tests of check.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/result/criteria.h"
#include "check/outcome.h"

namespace meshgauge::check {

// A gate with this limit, as a request for one has it.
inline void set_limit(Gate& gate, double max_distance, std::optional<LengthUnit> unit = std::nullopt) {
  api::ComparisonOptions& options = gate.request.options;
  options.max_distance = max_distance;
  options.units.limit = unit;
  options.tolerance = api::kToleranceOfGate;
  options.narrow = true;
}

// A limit of the area instead of that of the distance.
inline void set_area_limit(Gate& gate, api::ShareLimit limit) {
  gate.request.options.max_distance.reset();
  gate.request.options.max_share_beyond = limit;
  gate.request.options.tolerance = api::kToleranceOfArea;
}

// A share of the diagonal, 0.01 for one percent.
inline void set_share_of_diagonal(Gate& gate, double share) {
  set_limit(gate, share);
  gate.request.options.units.limit_of_diagonal = true;
}

inline Criterion distance(double lower, double upper, double limit, const std::string& status = "converged") {
  Criterion made;
  made.lower = lower;
  made.upper = upper;
  made.limit = limit;
  made.status = status;
  return api::judged(std::move(made));
}

inline Criterion in_region(const std::string& region, Criterion made) {
  made.region = region;
  return api::judged(std::move(made));
}

inline Criterion on_side(const std::string& side, Criterion made) {
  made.side = side;
  return api::judged(std::move(made));
}

inline Criterion share(double beyond, double limit, double lower, double upper,
                       const std::string& status = "complete") {
  Criterion made = distance(lower, upper, limit, status);
  made.of = Criterion::Of::share;
  made.beyond = beyond;
  return api::judged(std::move(made));
}

// With what follows from them: the verdict, and from the one of the distance the interval.
inline void set_criteria(Measured& measured, std::vector<Criterion> criteria) {
  for (Criterion& criterion : criteria) criterion = api::judged(std::move(criterion));
  measured.criteria = std::move(criteria);
  measured.verdict = verdict_of(*api::worst(measured.criteria));
  measured.reached = measured.foremost().lower;
  if (const Criterion* found = measured.distance()) {
    measured.lower = found->lower;
    measured.upper = found->upper;
    measured.status = found->status;
  }
}

// Changes the criteria by `change`.
inline void change(Measured& measured, const auto& change) {
  std::vector<Criterion> criteria = measured.criteria;
  for (Criterion& criterion : criteria) change(criterion);
  set_criteria(measured, std::move(criteria));
}

}  // namespace meshgauge::check
