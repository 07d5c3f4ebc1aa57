// The last stage of a measurement: statistics of sampled distances, once the interval is final.
#pragma once

#include <functional>

#include "engine/control.h"
#include "engine/measured_pair.h"
#include "engine/statistics.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Samples each direction of `pair` and fills `statistics`. On a deadline, a cancellation or lack of memory `status`
// says so, and the directions that were done stay. Does not throw std::bad_alloc. Calls `tell` now and then, on this
// thread.
void take_statistics(const MeasuredPair& pair, const Sampling& sampling, ThreadPool& pool, Control& control,
                     const std::function<void()>& tell, Statistics& statistics);

}  // namespace meshgauge
