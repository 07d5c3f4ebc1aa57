// Criteria and measurements for the tests of check.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "api/criteria.h"
#include "check/outcome.h"

namespace meshgauge::check {

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
  if (const Criterion* found = measured.find(Criterion::Of::distance)) {
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
