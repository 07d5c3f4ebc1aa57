#include "check/html/field.h"

#include <cmath>

#include "engine/tree/nearest.h"

namespace meshgauge::check {
namespace {

// In the frame: smaller distances are rounding errors of a point on the mesh.
constexpr double kOnMesh = 0x1p-44;

}  // namespace

DistanceField::DistanceField(const Prepared& mesh, const Box& box, ThreadPool& pool, Control& control)
    : frame_(box), framed_(mesh.in(frame_, *find_kernels("auto"))), tree_(framed_->tree(control, pool)) {}

double DistanceField::at(const Vec3& point) const {
  std::uint64_t tests = 0;
  const double distance = nearest(*tree_, frame_.to_frame(point), tests).distance;
  return distance < kOnMesh ? 0 : std::ldexp(distance, frame_.exponent());
}

}  // namespace meshgauge::check
