#include "engine/extras/statistics/statistics_stage.h"

#include <cstdint>
#include <new>
#include <optional>

#include "engine/extras/statistics/sampled_distances.h"

namespace meshgauge {
namespace {

StatisticsStatus to_status(Interruption interruption) {
  return interruption == Interruption::timeout ? StatisticsStatus::timeout : StatisticsStatus::cancelled;
}

}  // namespace

void take_statistics(const MeasuredPair& pair, const Sampling& sampling, ThreadPool& pool, Control& control,
                     const std::function<void()>& tell, Statistics& statistics) {
  statistics.sampling = sampling;
  try {
    for (const MeasuredDirection& direction : pair.directions) {
      const bool from_a = &direction.from == &pair.a;
      const std::uint32_t stream = from_a ? 0 : 1;
      auto& found = from_a ? statistics.a_to_b : statistics.b_to_a;
      found = distribution({*direction.from.framed, *direction.to.framed, sampling, stream, pool, control, tell},
                           direction.result.bounds.upper);
      if (!found) statistics.status = to_status(control.check());
    }
  } catch (const std::bad_alloc&) {
    statistics.status = StatisticsStatus::memory;
  }
}

}  // namespace meshgauge
