// Both meshes of a comparison in the unit of its result.
#pragma once

#include <memory>

#include "api/prepared_mesh.h"
#include "api/unit_plan.h"

namespace meshgauge::api {

struct MeasuredPair {
  std::shared_ptr<const Prepared> a;
  std::shared_ptr<const Prepared> b;
};

// Converts both meshes to the unit of the result. Errors: as for in_unit().
Result<MeasuredPair> in_unit_of_result(const std::shared_ptr<const PreparedMesh>& a,
                                       const std::shared_ptr<const PreparedMesh>& b, const UnitPlan& units,
                                       Control& control);

}  // namespace meshgauge::api
