#include "api/measured_pair.h"

#include <utility>

#include "api/align.h"

namespace meshgauge::api {

Result<MeasuredPair> in_unit_of_result(const std::shared_ptr<const PreparedMesh>& a,
                                       const std::shared_ptr<const PreparedMesh>& b, const UnitPlan& units,
                                       const std::optional<RigidMotion>& motion, Control& control) {
  auto measured_a = in_unit(a, "a", factor_between(units.a, units.result), control);
  if (!measured_a) return std::move(measured_a).error();
  if (motion) measured_a = moved(*measured_a, *motion, "a", control);
  if (!measured_a) return std::move(measured_a).error();
  auto measured_b = in_unit(b, "b", factor_between(units.b, units.result), control);
  if (!measured_b) return std::move(measured_b).error();
  return MeasuredPair{*std::move(measured_a), *std::move(measured_b)};
}

}  // namespace meshgauge::api
