// Both meshes of a comparison in the unit of its result.
#pragma once

#include <memory>
#include <optional>

#include "api/prepared_mesh.h"
#include "api/unit_plan.h"
#include "engine/mesh/rigid.h"

namespace meshgauge::api {

struct MeasuredPair {
  std::shared_ptr<const Prepared> a;
  std::shared_ptr<const Prepared> b;
};

// Converts both meshes to the unit of the result and moves `a` by the motion of its alignment; nullopt: none. Errors:
// as for in_unit() and moved().
Result<MeasuredPair> in_unit_of_result(const std::shared_ptr<const PreparedMesh>& a,
                                       const std::shared_ptr<const PreparedMesh>& b, const UnitPlan& units,
                                       const std::optional<RigidMotion>& motion, Control& control);

}  // namespace meshgauge::api
