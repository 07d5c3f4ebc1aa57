#include "engine/fast/front.h"

#include <type_traits>

#include "engine/fast/front_movement.h"
#include "engine/fast/front_points.h"
#include "engine/rounding.h"

namespace meshgauge {

FrontEnd take_front(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, Slack slack,
                    double& known, Control& control, ThreadPool& pool) {
  slack.residual = rounding::kUsualResidual;
  const auto run = [&]<class Front>(std::type_identity<Front>) {
    Front front(pair, direction, goal, slack, known, control, pool);
    const FrontEnd end = front.run();
    if (end == FrontEnd::taken) known = front.lower();
    return end;
  };
  const FrontEnd end = run(std::type_identity<MovementFront>());
  return end == FrontEnd::declined ? run(std::type_identity<PointFront>()) : end;
}

}  // namespace meshgauge
