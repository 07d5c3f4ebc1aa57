// Both meshes of a comparison as they were measured.
#pragma once

#include <memory>

#include "api/prepared_mesh.h"
#include "api/unit_plan.h"

namespace meshgauge::api {

struct MeasuredPair {
  std::shared_ptr<const Prepared> a;
  std::shared_ptr<const Prepared> b;
};

// Each as in_unit() gives it, in the unit of the result.
Result<MeasuredPair> in_unit_of_result(const std::shared_ptr<const PreparedMesh>& a,
                                       const std::shared_ptr<const PreparedMesh>& b, const UnitPlan& units,
                                       Control& control);

}  // namespace meshgauge::api
