#include "engine/front.h"

#include "engine/front_movement.h"
#include "engine/front_points.h"
#include "engine/rounding.h"

namespace meshgauge {

FrontEnd take_front(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, Slack slack,
                    double& known, Control& control, ThreadPool& pool) {
  slack.residual = rounding::kUsualResidual;
  MovementFront by_movement(pair, direction, goal, slack, known, control, pool);
  FrontEnd end = by_movement.run();
  if (end == FrontEnd::taken) known = by_movement.lower();
  if (end != FrontEnd::declined) return end;
  PointFront by_points(pair, direction, goal, slack, known, control, pool);
  end = by_points.run();
  if (end == FrontEnd::taken) known = by_points.lower();
  return end;
}

}  // namespace meshgauge
